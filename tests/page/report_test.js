/* SPDX-License-Identifier: MIT
 * report_test.js - a diagnosis' report in Chromium: readable at every width, in light and in dark.
 * usage: node report_test.js CHROMIUM REPORT.html */
"use strict";

const path = require("path");
const { open } = require("./browser.js");
const { claim, count } = require("./page_file.js");

/* text elements with a contrast below 4.5 (WCAG AA) */
const faint = `(() => {
  const parse = (c) => (c.match(/[\\d.]+/g) || []).map(Number);
  const light = (c) => { const f = (v) => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    return 0.2126 * f(c[0]) + 0.7152 * f(c[1]) + 0.0722 * f(c[2]); };
  const behind = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor);
    if (c.length === 3 || c[3] === 1) return c; } return [255, 255, 255]; };
  const bad = [];
  for (const e of document.querySelectorAll("h1,h2,h3,p,li,td,th,small,figcaption,summary,svg text")) {
    if (!e.textContent.trim()) continue;
    const s = getComputedStyle(e), a = light(parse(e instanceof SVGElement ? s.fill : s.color)), b = light(behind(e));
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) bad.push([e.tagName, e.textContent.trim().slice(0, 20), contrast.toFixed(2)]);
  }
  return bad.slice(0, 5);
})()`;

async function main([program, file]) {
  const b = await open(program), asked = [];
  b.on((method, p) => { if (method === "Network.requestWillBeSent") asked.push(p.request.url); });
  const wide = async (width) => {
    await b.call("Emulation.setDeviceMetricsOverride", { width, height: 900, deviceScaleFactor: 1, mobile: false });
    await b.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))");
  };
  await wide(1200);
  await b.call("Page.navigate", { url: `file://${path.resolve(file)}` });
  await b.until("document.readyState === 'complete' && document.querySelector('footer') !== null");
  claim("nothing is loaded but the file", asked.every((u) => u.startsWith("file://")), asked.join(" "));
  claim("there are no scripts", await b.evaluate("document.scripts.length") === 0);
  claim("axes have text of 16 px at 1200 px", await b.evaluate(
    "Math.min(...[...document.querySelectorAll('figure svg text.tick')].map((t) => " +
    "parseFloat(getComputedStyle(t).fontSize) * t.getScreenCTM().a)) >= 16"));
  claim("the first screen has verdict, size, error, rivals, remainder and next step", await b.evaluate(
    "document.querySelectorAll('header .card').length >= 5 && " +
    "document.querySelector('header .card:last-child').getBoundingClientRect().bottom < 900"));
  claim("a strip of a picture shows its values",
        await b.evaluate("/measured .*after /.test(document.querySelector('.tip title').textContent)"));
  claim("pictures have names", await b.evaluate(
    "[...document.querySelectorAll('svg[role=img]')].every((s) => s.getAttribute('aria-label'))"));
  for (const width of [390, 800, 1400]) {
    await wide(width);
    const reach = await b.evaluate("document.documentElement.scrollWidth");
    claim(`the page fits ${width} px`, reach <= width, reach);
    const px = await b.evaluate("Math.min(...[...document.querySelectorAll('figure svg text')].filter((t) => t.getScreenCTM())" +
      ".map((t) => parseFloat(getComputedStyle(t).fontSize) * t.getScreenCTM().a))");
    claim(`no text of a picture is below 9.5 px at ${width} px`, px >= 9.5, px);
  }
  await wide(390);
  claim("rows of tables are blocks on a phone", await b.evaluate(
    "[...document.querySelectorAll('.fold td')].every((t) => ['block', 'none'].includes(getComputedStyle(t).display))"));
  const papers = [];
  for (const value of ["light", "dark"]) {
    await b.call("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value }] });
    papers.push(await b.evaluate("getComputedStyle(document.body).backgroundColor"));
    const bad = await b.evaluate(faint);
    claim(`all words can be read in ${value}`, bad.length === 0, JSON.stringify(bad));
  }
  claim("dark is another paper", papers[0] !== papers[1], papers.join(" "));
  await b.close();
}

main(process.argv.slice(2)).catch((e) => claim(e.message, false))
  .then(() => { console.log(`${count.passed} ${count.failed}`); process.exit(0); });
