/* SPDX-License-Identifier: MIT
 * axe_test.js - barriers that axe-core finds in written pages, on a wide and a narrow window, light
 * and dark. Serious and critical findings fail. Prints failures and "PASSED FAILED".
 *
 *   node axe_test.js CHROMIUM AXE.js FILE.html... */
"use strict";

const fs = require("fs");
const path = require("path");
const { open } = require("./browser.js");
const { claim, count } = require("./page_file.js");

const [program, axe, ...files] = process.argv.slice(2);
const grave = ["serious", "critical"];

async function findings(b, file, width, scheme) {
  await b.call("Emulation.setDeviceMetricsOverride", { width, height: 800, deviceScaleFactor: 1, mobile: width < 600 });
  await b.call("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
  await b.call("Page.navigate", { url: "about:blank" });
  await b.call("Page.navigate", { url: "file://" + path.resolve(file) });
  await b.until(`document.readyState === "complete" && (!document.getElementById("code") || document.documentElement.dataset.ready !== undefined)`);
  await b.evaluate(fs.readFileSync(axe, "utf8") + "; true");
  const found = JSON.parse(await b.evaluate("axe.run(document).then((r) => JSON.stringify({ passes: r.passes.length, all: r.violations.map((v) => ({ id: v.id, impact: v.impact, at: v.nodes.slice(0, 3).map((n) => n.target.join(' ')), n: v.nodes.length })) }))"));
  return { ...found, grave: found.all.filter((v) => grave.includes(v.impact)) };
}

async function check(b, file, width, scheme) {
  const found = await findings(b, file, width, scheme), name = `${path.basename(file)}, ${width} px, ${scheme}`;
  claim(`${name}: rules were tried`, found.passes > 5, found.passes);
  claim(`${name}: no serious barrier`, found.grave.length === 0, JSON.stringify(found.grave));
  for (const v of found.all.filter((w) => !grave.includes(w.impact)))
    console.log(`${name}: ${v.impact}: ${v.id} at ${v.at[0]} (${v.n})`);
}

async function run() {
  const b = await open(program);
  try {
    // the content policy of a page forbids scripts that are not its own
    await b.call("Page.setBypassCSP", { enabled: true });
    for (const file of files) {
      await check(b, file, 1200, "light");
      await check(b, file, 1200, "dark");
      await check(b, file, 390, "light");
    }
    const barriers = files[0] + ".barriers.html";
    fs.writeFileSync(barriers, "<!doctype html><html><body><img src=x><button></button></body></html>");
    claim("barriers are found where there are some", (await findings(b, barriers, 1200, "light")).grave.length > 1);
  } catch (e) {
    claim(`axe runs through (${e.message})`, false);
  }
  await b.close();
  console.log(`${count.passed} ${count.failed}`);
}

run().catch((e) => { console.log(`FAILED: ${e.stack}`); console.log("0 1"); });
