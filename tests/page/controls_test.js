/* SPDX-License-Identifier: MIT
 * controls_test.js - pause, single steps, the last stroke again, frozen strokes, settings in the
 * address and the four languages, in Chromium. Prints failures and "PASSED FAILED".
 *
 *   node controls_test.js CHROMIUM PAGE RECORD.csv PAGE-OF-A-PENDULUM */
"use strict";

const fs = require("fs");
const path = require("path");
const { open } = require("./browser.js");
const { claim, count, read } = require("./page_file.js");

const [program, file, record, pendulum] = process.argv.slice(2), address = "file://" + path.resolve(file);
const engine = "Page.engine()", last = "Page.strokes().list.at(-1)";
const click = (b, id) => b.evaluate(`document.getElementById("${id}").click()`);
const text = (b, id) => b.evaluate(`document.getElementById("${id}").textContent`);
const frames = (b) => b.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(r))))");
const setRange = (b, id, v) => b.evaluate(`(() => { const s = document.getElementById("${id}"); s.value = ${v}; s.dispatchEvent(new Event("input")); })()`);

async function go(b, hash) { // another address of the same file would only move the hash
  await b.call("Page.navigate", { url: "about:blank" });
  await b.call("Page.navigate", { url: address + hash });
  await b.until(`document.documentElement?.dataset.ready !== undefined`);
}
const width = (b, w) => b.call("Emulation.setDeviceMetricsOverride", { width: w, height: 800, deviceScaleFactor: 1, mobile: w < 600 });

async function stroke(b) {
  await setRange(b, "speed", 100);
  await b.evaluate("document.activeElement.blur()");
  await b.key("keyDown", " ", "Space");
  await b.until(`Page.strokes().list.length > 0 && ${last}.over`);
  await b.key("keyUp", " ", "Space");
}

async function pausing(b) {
  await go(b, "#speed=0");
  await b.key("keyDown", " ", "Space");
  await b.until(`${engine}.time() > 0.0002`);
  await b.key("keyDown", "p", "KeyP");
  await b.key("keyUp", "p", "KeyP");
  const t0 = await b.evaluate(`${engine}.time()`);
  await frames(b);
  claim("P stops the time", await b.evaluate(`${engine}.time()`) === t0);
  claim("the button tells", await b.evaluate(`document.getElementById("pause").getAttribute("aria-pressed")`) === "true" && await text(b, "pause") === "Go on");
  claim("and the state", /^.*paused at/.test(await text(b, "state")), await text(b, "state"));
  const steps = await b.evaluate(`Math.round(${engine}.model.until / ${engine}.model.dt / 1000)`), dt = await b.evaluate(`${engine}.model.dt`);
  await click(b, "step");
  const t1 = await b.evaluate(`${engine}.time()`);
  claim("a step goes to the next sample and stops", t1 > t0 && t1 - t0 < (steps + 0.5) * dt, [t0, t1]);
  await b.evaluate("document.activeElement.blur()");
  await b.key("keyDown", ".", "Period");
  await b.key("keyUp", ".", "Period");
  claim("so does the full stop", Math.abs(await b.evaluate(`${engine}.time()`) - t1 - steps * dt) < 1e-9);
  await click(b, "pause");
  await b.until(`${engine}.time() > ${t1} + ${2 * steps * dt}`);
  claim("it goes on", await text(b, "pause") === "Pause");
  await b.key("keyUp", " ", "Space");
}

async function again(b) {
  await go(b, "");
  claim("without a stroke there is nothing to look at again", await b.evaluate(`document.getElementById("scrub").disabled`));
  await stroke(b);
  await b.until(`${engine}.armed() && ${engine}.stir() < 2e-3`);
  const n = await b.evaluate("Page.replay().length()"), t = await b.evaluate(`${engine}.time()`);
  claim("a stroke leaves samples", n > 100, n);
  await b.evaluate(`${engine}.advance(Math.round(0.8 / ${engine}.model.dt))`); // the trace holds less than that
  await setRange(b, "scrub", 160);
  const now = await b.evaluate(`${engine}.time()`);
  await frames(b);
  claim("looking at it stops the time", now >= t && await b.evaluate(`Page.paused() && ${engine}.time() === ${now}`));
  const drawn = await b.evaluate(`(() => { const g = Page.geometry(), i = ${engine}.model.bodies.findIndex((k) => k.name === "hammer"), at = () => g.local(i, 0.05, 0);
    const seen = at(); g.place(Page.replay().sample(160).q); const then = at(); g.place(${engine}.q());
    return [seen, then, at()]; })()`);
  const far = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1]);
  claim("what is drawn is then", far(drawn[0], drawn[1]) === 0 && far(drawn[0], drawn[2]) > 1e-3, JSON.stringify(drawn));
  const shown = await text(b, "scrub-shown");
  claim("the bar tells when", /^\d+\.\d ms$/.test(shown) && await b.evaluate(`document.getElementById("scrub").getAttribute("aria-valuetext")`) === shown, shown);
  claim("the traces show the moment", await b.evaluate(`(() => { const i = document.createElement("i"); i.style.color = "var(--ink)"; document.body.append(i);
    const [r, g, b] = getComputedStyle(i).color.match(/\\d+/g).map(Number), c = document.getElementById("traces"); i.remove();
    const d = c.getContext("2d").getImageData(0, 0, c.width, c.height - 20).data, n = new Map();
    for (let k = 0; k < d.length; k += 4) if (Math.abs(d[k] - r) + Math.abs(d[k + 1] - g) + Math.abs(d[k + 2] - b) < 8 && d[k + 3] > 200) { const x = k / 4 % c.width; n.set(x, (n.get(x) || 0) + 1); }
    return [...n.values()].some((v) => v > 0.6 * c.height); })()`));
  const coloured = await b.evaluate(`(() => { const i = document.createElement("i"); i.style.color = "var(--tone0)"; document.body.append(i);
    const [r, g, b] = getComputedStyle(i).color.match(/\\d+/g).map(Number), c = document.getElementById("traces"); i.remove();
    const d = c.getContext("2d").getImageData(0, 0, c.width / 2, c.height).data; let n = 0;
    for (let k = 0; k < d.length; k += 4) n += Math.abs(d[k] - r) + Math.abs(d[k + 1] - g) + Math.abs(d[k + 2] - b) < 30;
    return n; })()`);
  claim("a stroke has its curves from its beginning, also when the trace has gone on", coloured > 100, coloured);
  claim("and stays where it was put", await b.evaluate(`document.getElementById("scrub").value`) === "160");
  const strokes = await b.evaluate("Page.strokes().list.length");
  await b.evaluate("document.activeElement.blur()");
  await b.key("keyDown", " ", "Space");
  await b.until(`Page.strokes().list.length === ${strokes + 1} && !Page.paused() && ${last}.over`);
  await b.key("keyUp", " ", "Space");
  claim("the next press goes on by itself", true);
}

/* pixels of a canvas in a colour of the page's style */
const pixels = (b, canvas, colour) => b.evaluate(`(() => { const i = document.createElement("i"); i.style.color = "var(--${colour})"; document.body.append(i);
  const [r, g, b] = getComputedStyle(i).color.match(/\\d+/g).map(Number), c = document.getElementById("${canvas}"); i.remove();
  const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let k = 0; k < d.length; k += 4) n += Math.abs(d[k] - r) + Math.abs(d[k + 1] - g) + Math.abs(d[k + 2] - b) < 8 && d[k + 3] > 200;
  return n; })()`);

async function freezing(b) {
  await setRange(b, "scrub", 80); // the hammer is on its way, away from where it rests
  const before = await pixels(b, "stage", "rule");
  claim("nothing is frozen", await b.evaluate(`document.getElementById("thaw").hidden && Page.replay().frozen.length === 0`));
  await click(b, "freeze");
  claim("a stroke is frozen", await b.evaluate("Page.replay().frozen.length") === 1 && /Frozen/.test(await text(b, "announce")));
  await setRange(b, "dial0", 100);
  await stroke(b);
  await b.until(`${engine}.armed() && ${engine}.stir() < 2e-3`);
  await setRange(b, "scrub", 80);
  claim("it is drawn under the next one", await pixels(b, "stage", "rule") > before + 200, [before, await pixels(b, "stage", "rule")]);
  claim("with the regulation that it had", await b.evaluate(`Math.abs(Page.replay().ghosts(0.01)[0].params[${engine}.model.dials[0].param] - ${engine}.value(${engine}.model.dials[0].param)) > 1e-4`));
  claim("and the drawing has its own again", await b.evaluate(`Page.geometry().params[${engine}.model.dials[0].param] === ${engine}.value(${engine}.model.dials[0].param)`));
  for (let i = 0; i < 4; i++) await click(b, "freeze");
  claim("three are kept", await b.evaluate("Page.replay().frozen.length") === 3 && await text(b, "thaw") === "Clear frozen (3)");
  await click(b, "thaw");
  claim("and cleared", await b.evaluate(`document.getElementById("thaw").hidden && Page.replay().frozen.length === 0`));
}

async function addresses(b) {
  await go(b, "");
  await setRange(b, "dial0", 300);
  await setRange(b, "speed", 55);
  const hash = await b.evaluate("location.hash"), value = await b.evaluate(`${engine}.model.dials[0].from + 0.3 * (${engine}.model.dials[0].to - ${engine}.model.dials[0].from)`);
  claim("the address has what was set", /pawl\.stop_shift=-/.test(hash) && /speed=55/.test(hash), hash);
  await go(b, hash);
  claim("and sets it again", await b.evaluate(`Math.abs(${engine}.value(${engine}.model.dials[0].param) - ${value})`) < 1e-8 &&
        await b.evaluate(`Math.abs(document.getElementById("dial0").value - 300) < 1.5 && document.getElementById("speed").value === "55"`));
  claim("the slider shows that it was turned", await b.evaluate(`document.querySelector(".dial").classList.contains("turned")`));
  await b.evaluate(`document.querySelector(".dial button").click()`);
  claim("reset takes it out", !/stop_shift/.test(await b.evaluate("location.hash")));
  await b.evaluate(`location.hash = "#pawl.stop_shift=-0.0004"`);
  await b.until(`Math.abs(${engine}.value(${engine}.model.dials[0].param) + 0.0004) < 1e-6`, 5000).catch(() => {});
  claim("a link that is followed turns the slider", await b.evaluate(`document.querySelector(".dial output").textContent`) === "−0.400 mm");
  await go(b, "#pawl.stop_shift=99&pawl.spring.k=soft&nothing=1&lang=xx&speed=");
  claim("what cannot be is brought within reach or left out", await b.evaluate(`document.documentElement.dataset.ready === "yes" && document.documentElement.lang === "en" &&
    ${engine}.value(${engine}.model.dials[0].param) === ${engine}.model.dials[0].to && !document.querySelectorAll(".dial")[1].classList.contains("turned")`));
}

function records() {
  const { Measured, model } = read(file), at = (name) => model.channels.findIndex((c) => c.name === name);
  const own = Measured.read(fs.readFileSync(record, "utf8"), model), first = own.samples[0];
  claim("a record is read by its names", own.channels.includes(at("string_distance")) && own.samples.length > 100 &&
        first.t === -0.005 && first.values[at("string_distance")] === 0.03916, JSON.stringify(first));
  const other = Measured.read("\uFEFF# a note\nt [ms];key_dip (mm);other\r\n0;1,5;7\r\n2,5;;8\r\n", model);
  claim("also with semicolons, decimal commas and other units", other.samples.length === 2 && Math.abs(other.samples[1].t - 0.0025) < 1e-12 &&
        Math.abs(other.samples[0].values[at("key_dip")] - 0.0015) < 1e-12 && Number.isNaN(other.samples[1].values[at("key_dip")]));
  for (const [what, text] of [["no names", "1,2\n3,4\n"], ["an unknown unit", "time [s],key_dip [furlong]\n0,1\n1,2\n"],
                              ["words for times", "time,key_dip\nnow,1\nthen,2\n"], ["one row", "time,key_dip\n0,1\n"], ["nothing", ""]]) {
    let refused = false;
    try { Measured.read(text, model); } catch (e) { refused = true; }
    claim(`${what}: no record`, refused);
  }
}

async function measuring(b) {
  records();
  await go(b, "");
  await stroke(b);
  await b.until(`${engine}.armed() && ${engine}.stir() < 2e-3`);
  await setRange(b, "scrub", 250);
  const before = await pixels(b, "traces", "ink");
  const { root } = await b.call("DOM.getDocument"), { nodeId } = await b.call("DOM.querySelector", { nodeId: root.nodeId, selector: "#file" });
  await b.call("DOM.setFileInputFiles", { nodeId, files: [path.resolve(record)] });
  await b.until(`document.getElementById("measured").textContent !== ""`);
  claim("a measured stroke is told", /is drawn over the traces/.test(await text(b, "measured")), await text(b, "measured"));
  claim("and drawn", await pixels(b, "traces", "ink") > before + 200, [before, await pixels(b, "traces", "ink")]);
  await b.call("DOM.setFileInputFiles", { nodeId, files: [path.resolve(__filename)] });
  await b.until(`/is no record/.test(document.getElementById("measured").textContent)`);
  claim("a file that is no record is reported, and nothing is drawn", await pixels(b, "traces", "ink") < before + 50);
}

async function touring(b) {
  await go(b, "#pawl.stop_shift=-0.0007");
  await click(b, "tour-start");
  claim("the tour begins with the file's regulation", await b.evaluate("Page.tour().step()") === 1 && /^1 of 4/.test(await text(b, "tour-text")));
  await b.until(`Math.abs(${engine}.value(${engine}.model.dials[0].param)) < 1e-9 && ${engine}.stir() < 2e-3`);
  await stroke(b);
  await b.until("Page.tour().step() === 2");
  claim("a stroke takes it on, and the stop is displaced", /^2 of 4/.test(await text(b, "tour-text")));
  await b.until(`Math.abs(${engine}.value(${engine}.model.dials[0].param) - 0.00025) < 1e-9 && ${engine}.armed() && ${engine}.stir() < 2e-3`);
  await stroke(b);
  await b.until("Page.tour().step() === 3");
  claim("the next one is not as it should be", await b.evaluate(`!(${last}.escapeTime < ${last}.impactTime)`) && /^3 of 4/.test(await text(b, "tour-text")), await b.evaluate(last));
  const to = async (dx) => {
    await b.evaluate(`(() => { const d = ${engine}.model.dials[0], i = document.getElementById("dial0"); i.value = 1000 * (${dx} - d.from) / (d.to - d.from); i.dispatchEvent(new Event("input")); })()`);
    await b.until(`Math.abs(${engine}.value(${engine}.model.dials[0].param) - ${dx}) < 1e-6 && ${engine}.armed() && ${engine}.stir() < 2e-3`);
    const n = await b.evaluate("Page.strokes().list.length");
    await b.evaluate("document.activeElement.blur()");
    await b.key("keyDown", " ", "Space");
    await b.until(`Page.strokes().list.length === ${n + 1} && ${last}.over`);
    await b.key("keyUp", " ", "Space");
    await frames(b);
  };
  await to(-0.0008);
  claim("too far to the left is not it", await b.evaluate("Page.tour().step()") === 3);
  await to(0);
  await b.until("Page.tour().step() === 4");
  claim("the right place is found", /Found: the hammer escapes [1-3]\.\d mm/.test(await text(b, "tour-text")), await text(b, "tour-text"));
  await click(b, "tour-next");
  claim("it ends", await b.evaluate(`document.getElementById("tour").hidden && Page.tour().step() === 0`));
}

async function beginning(b) {
  await b.call("Page.navigate", { url: "file://" + path.resolve(pendulum) });
  await b.until(`document.documentElement?.dataset.ready === "yes" && Page.engine().model.name === "pendulum"`);
  const i = await b.evaluate(`${engine}.model.dials.findIndex((d) => d.name === "rod.initial.position")`);
  claim("the beginning has a slider", i >= 0);
  claim("which says that it starts again", /\(starts again\)$/.test(await b.evaluate(`document.querySelector("label[for=dial${i}]").textContent`)));
  await b.until(`${engine}.time() > 0.05`);
  const [q, t, aim] = await b.evaluate(`(() => { const s = document.getElementById("dial${i}"), d = ${engine}.model.dials[${i}]; s.value = 900;
    s.dispatchEvent(new Event("input")); return [${engine}.q()[0], ${engine}.time(), d.from + 0.9 * (d.to - d.from)]; })()`);
  claim("turned it begins there", t === 0 && Math.abs(q - aim) < 1e-3, [q, t, aim]);
}

async function languages(b) {
  const { Words } = read(file);
  const broken = Object.entries(Words.all).filter(([, list]) => list.length !== 4 || list.some((t) => !t ||
    String(t.match(/\{\d\}/g)) !== String(list[0].match(/\{\d\}/g)))).map(([k]) => k);
  claim("every text is there in four languages, with the same gaps", broken.length === 0, broken);
  const seen = [];
  for (const code of Words.languages) {
    await width(b, 1100);
    await go(b, `#lang=${code}`);
    claim(`${code}: the page says so`, await b.evaluate("document.documentElement.lang") === code);
    claim(`${code}: no word is missing`, await b.evaluate(`[...document.querySelectorAll("[data-t], [data-h], button")].every((e) => e.hidden || e.textContent.trim() !== "") &&
      [...document.querySelectorAll("[data-l]")].every((e) => e.getAttribute("aria-label")) && !/\\{\\d\\}/.test(document.body.innerText)`));
    seen.push(await text(b, "again") + (await text(b, "title")) + await text(b, "dials-title"));
    await width(b, 360);
    claim(`${code}: a phone need not scroll sideways`, await b.evaluate("document.documentElement.scrollWidth") <= 360);
  }
  claim("the languages differ", new Set(seen).size === 4, seen);
  await width(b, 1100);
  await go(b, "#pawl.stop_shift=-0.0005");
  await b.evaluate(`(() => { const s = document.getElementById("language"); s.value = "fr"; s.dispatchEvent(new Event("change")); })()`);
  await b.until(`document.documentElement?.dataset.ready === "yes" && document.documentElement.lang === "fr"`);
  claim("the list changes the language and keeps the settings", await text(b, "pause") === "Pause" && await text(b, "again") === "Recommencer" &&
        await b.evaluate(`Math.abs(${engine}.value(${engine}.model.dials[0].param) + 0.0005) < 1e-9`));
}

async function named(b) {
  await go(b, "");
  await stroke(b);
  await b.call("Accessibility.enable");
  const { nodes } = await b.call("Accessibility.getFullAXTree");
  const sliders = nodes.filter((n) => !n.ignored && n.role?.value === "slider").map((n) => n.name?.value);
  claim("every slider has a unique name", sliders.length > 8 && sliders.every((n) => n) && new Set(sliders).size === sliders.length, sliders);
}

async function run() {
  const b = await open(program), broken = [];
  b.on((method, p) => { if (method === "Runtime.exceptionThrown") broken.push(p.exceptionDetails.exception?.description); });
  try {
    claim("the page has at most 400 KB", fs.statSync(file).size <= 400e3, fs.statSync(file).size);
    await width(b, 1100);
    await pausing(b);
    await again(b);
    await freezing(b);
    await measuring(b);
    await addresses(b);
    await languages(b);
    await touring(b);
    await named(b);
    await beginning(b);
    claim("no script failed", broken.length === 0, broken);
  } catch (e) {
    claim(`the controls' part runs through (${e.message})`, false);
  }
  await b.close();
  console.log(`${count.passed} ${count.failed}`);
}

run().catch((e) => { console.log(`FAILED: ${e.stack}`); console.log("0 1"); });
