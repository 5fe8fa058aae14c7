/* SPDX-License-Identifier: MIT
 * browser_test.js - the page in Chromium, opened from disk: played by keys, mouse and finger,
 * regulated in the middle of a stroke, heard, read. Prints failures, what a frame costs, and
 * "PASSED FAILED".
 *
 *   [PICTURES=FOLDER] node browser_test.js CHROMIUM PAGE [PAGE-OF-ANOTHER-MECHANISM...] */
"use strict";

const fs = require("fs");
const path = require("path");
const { open } = require("./browser.js");
const { claim, count } = require("./page_file.js");

const [program, file, ...others] = process.argv.slice(2), pictures = process.env.PICTURES;
const address = (page) => "file://" + path.resolve(page);
const engine = "Page.engine()", last = "Page.strokes().list.at(-1)";
const cell = (i) => `document.querySelector("#table tr").cells[${i}].textContent`;

const click = (b, at) => b.mouse("mousePressed", at).then(() => b.mouse("mouseReleased", at));

async function look(b, { width = 1100, height = 800, dark = false, name }) {
  await b.call("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 600 });
  await b.call("Emulation.setEmulatedMedia",
    { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
  await b.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))");
  if (!pictures) return;
  const shot = await b.call("Page.captureScreenshot", { format: "png" });
  fs.writeFileSync(path.join(pictures, name + ".png"), Buffer.from(shot.data, "base64"));
}

async function tap(b, key, code) {
  await b.key("keyDown", key, code);
  await b.key("keyUp", key, code);
}

const setSpeed = (v) => `(() => { const s = document.getElementById("speed"); s.value = ${v}; s.dispatchEvent(new Event("input")); })()`;

/* how many pixels of a canvas have a colour of the page's style */
const pixels = (b, canvas, colour) => b.evaluate(`(() => { const i = document.createElement("i"); i.style.color = "var(--${colour})"; document.body.append(i);
  const [r, g, b] = getComputedStyle(i).color.match(/\\d+/g).map(Number), c = document.getElementById("${canvas}"); i.remove();
  const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let k = 0; k < d.length; k += 4) n += Math.abs(d[k] - r) + Math.abs(d[k + 1] - g) + Math.abs(d[k + 2] - b) < 8 && d[k + 3] > 200;
  return n; })()`);

async function whatIsShown(b) {
  claim("distance, phase and forces are traced", await b.evaluate(
    `["string distance", "notch phase", "string force", "notch force"].every((w) => document.getElementById("legend").textContent.includes(w))`),
        await b.evaluate(`document.getElementById("legend").textContent`));
  claim("the paper's line is in the chart, and no stroke", await pixels(b, "chart", "tone1") > 100 && await pixels(b, "chart", "tone0") === 0);
  claim("nothing is traced yet", await pixels(b, "traces", "tone0") === 0);
}

async function aSlowStroke(b) {
  await b.evaluate("document.activeElement.blur()");
  // as slow as can be from the moment when the beak hangs on the corner: time for thirty keys
  await b.evaluate(`(() => { const f = () => { if (${engine}.phase() === 3) ${setSpeed(0)}; else requestAnimationFrame(f); }; f(); })()`);
  await b.key("keyDown", " ", "Space");
  await b.until(`${engine}.phase() === 3 && document.getElementById("speed").value === "0"`);
  claim("the space bar presses the key", await b.evaluate(
    `document.querySelector("[data-input]").getAttribute("aria-pressed") === "true"`));
  await look(b, { name: "stroke" });
  // the stop, by the arrow keys
  const before = await b.evaluate(`${engine}.time()`);
  await b.evaluate(`document.getElementById("dial0").focus()`);
  for (let i = 0; i < 30; i++) await tap(b, "ArrowLeft", "ArrowLeft");
  const turned = await b.evaluate(`[${engine}.value(0), ${engine}.time(), +document.getElementById("dial0").value, ${engine}.phase()]`);
  const aim = await b.evaluate("(() => { const d = Page.engine().model.dials[0]; return d.from + (d.to - d.from) * document.getElementById('dial0').value / 1000; })()");
  claim("a dial turns while it runs", aim < -0.00004 && turned[1] > before, [aim, turned[1] - before]);
  await b.until(`Math.abs(${engine}.value(0) - ${aim}) < 1e-12`);
  claim("and the parameter arrives there, before the beak is out", await b.evaluate(`${engine}.phase() === 3`));
  await b.evaluate(setSpeed(70));
  await b.until(`${last}.over`);
  await b.key("keyUp", " ", "Space");
  const s = await b.evaluate(last);
  claim("the stroke goes on to its end", s.impacts >= 1 && s.escapeHeight > 0, JSON.stringify(s));
  claim("with the stop where it is now", Math.abs(s.dx - aim) < 1e-12, s.dx);
  claim("its row has the numbers", await b.evaluate(
    `${cell(1)}.replace("−", "-") === (1e3 * ${last}.dx).toFixed(2) && ${cell(2)} === (1e3 * ${last}.escapeHeight).toFixed(2) && ` +
    `${cell(3)} === ${last}.impactSpeed.toFixed(2) && ${cell(4)} === ${last}.peak.toFixed(2) && ${cell(5)} === Strokes.outcome(${last})`));
  claim("the stroke is a point of the chart", await pixels(b, "chart", "tone0") > 20, await pixels(b, "chart", "tone0"));
  const traced = await pixels(b, "traces", "tone0"), then = await b.evaluate(`${engine}.time()`);
  await b.until(`${engine}.time() > ${then} + 0.03`);
  claim("traces scroll", traced > 100 && await pixels(b, "traces", "tone0") > traced + 20, [traced, await pixels(b, "traces", "tone0")]);
  claim("it is told once, in words", await b.evaluate(
    `document.querySelectorAll("[aria-live]").length === 1 && /^Stroke 1: .* newtons\\.$/.test(document.getElementById("announce").textContent)`));
}

/* every dial, while the beak hangs on the corner */
async function everyDial(b) {
  await tap(b, "R", "KeyR"); // with Caps Lock on
  await b.until(`${engine}.stir() < 2e-3`);
  await b.evaluate("document.activeElement.blur()");
  await b.evaluate(`(() => { const f = () => { if (${engine}.phase() === 3) ${setSpeed(0)}; else requestAnimationFrame(f); }; f(); })()`);
  await b.key("keyDown", " ", "Space");
  await b.until(`${engine}.phase() === 3 && document.getElementById("speed").value === "0"`);
  const before = await b.evaluate(`${engine}.time()`);
  const turned = [];
  await b.evaluate(`window.paces = [], (() => { const e = ${engine}, aim = e.aim; e.aim = (i, v, pace) => { paces.push([i, pace]); aim(i, v, pace); }; })()`);
  for (let i = 0; i < await b.evaluate(`${engine}.model.dials.length`); i++) {
    const place = `document.getElementById("dial${i}").focus(), document.getElementById("dial${i}").value / 1000`;
    const was = await b.evaluate(place);
    for (let k = 0; k < 4; k++) await tap(b, "ArrowRight", "ArrowRight");
    turned.push(await b.evaluate(place) - was);
  }
  claim("every dial has turned in the stroke", turned.length >= 9 && turned.every((t) => t > 0.003 && t < 0.006), turned);
  claim("none of them at once", await b.evaluate(`paces.length === 4 * ${turned.length} && paces.every(([i, pace]) => {
    const d = ${engine}.model.dials.find((k) => k.param === i); return Math.abs(pace * 0.06 / (d.to - d.from) - 1) < 1e-12; })`));
  await b.until(`${engine}.model.dials.every((d, i) => Math.abs(${engine}.value(d.param) - (d.from + (d.to - d.from) * document.getElementById("dial" + i).value / 1000)) < 1e-9 * (d.to - d.from))`);
  claim("and all are there before it is out", await b.evaluate(`${engine}.phase() === 3 && ${engine}.time() > ${before} && ${engine}.q().every(Number.isFinite)`));
  const finger = await b.evaluate(`${engine}.model.dials.length`), touch = await b.evaluate(`document.querySelector('output[for="dial${finger}"]').textContent`);
  await b.evaluate(`document.getElementById("dial${finger}").focus()`);
  await tap(b, "ArrowRight", "ArrowRight");
  claim("the finger has a dial, too", touch !== await b.evaluate(`document.querySelector('output[for="dial${finger}"]').textContent`), touch);
  await b.evaluate(setSpeed(100));
  await b.until(`${last}.over`);
  await b.key("keyUp", " ", "Space");
  for (let i = 0; i <= finger; i++) await b.evaluate(`document.querySelectorAll(".dial button")[${i}].click()`);
  await b.until(`${engine}.model.dials.every((d) => Math.abs(${engine}.value(d.param) - ${engine}.model.values[d.param]) < 1e-3 * (d.to - d.from)) && ${engine}.armed() && ${engine}.stir() < 2e-3`);
  claim("reset takes them back", await b.evaluate(`document.querySelectorAll(".dial.turned").length === 0`));
  // a slider that has the focus leaves the space bar to the key
  const n = await b.evaluate("Page.strokes().list.length");
  await b.evaluate(`document.getElementById("dial0").focus()`);
  await b.key("keyDown", " ", "Space");
  await b.until(`${last}.over`);
  await b.key("keyUp", " ", "Space");
  claim("the space bar presses the key beside a slider", await b.evaluate(`Page.strokes().list.length === ${n + 1} && ${last}.impacts > 0`));
  await b.until(`${engine}.armed() && ${engine}.stir() < 2e-3`);
}

/* place of a fraction of an element */
const placeOf = (b, id, u, v) => b.evaluate(`(() => { scrollTo(0, 0); const r = document.getElementById("${id}").getBoundingClientRect(); return [r.left + ${u} * r.width, r.top + ${v} * r.height]; })()`);

async function aMouse(b) {
  const n = await b.evaluate("Page.strokes().list.length"), key = await placeOf(b, "stage", 0.94, 0.7);
  await b.mouse("mousePressed", key);
  await b.until(`Page.strokes().list.length === ${n + 1} && ${last}.impacts > 0`);
  await b.mouse("mouseReleased", key);
  claim("the mouse strikes on the drawing", await b.evaluate(`Strokes.outcome(${last}) === "struck"`));
  await b.until(`${last}.over && ${engine}.armed() && ${engine}.stir() < 2e-3`);
  // the weight hangs above the key's front end, and stands on it when it is let go
  const weight = `(() => { const r = document.getElementById("stage").getBoundingClientRect(), w = Page.scene().weightAt(${engine}.loadPresent());
    return [r.left + w[0], r.top + w[1]]; })()`;
  await click(b, await b.evaluate(weight));
  claim("the weight can be touched", await b.evaluate(`${engine}.loadPresent()`));
  await b.until(`Page.strokes().list.length === ${n + 2} && ${last}.impacts > 0`);
  await click(b, await b.evaluate(weight));
  claim("and taken away again", await b.evaluate(`!${engine}.loadPresent()`));
  await b.until(`${last}.over && ${engine}.armed() && ${engine}.stir() < 2e-3`);
}

/* contexts and tones are counted from the first line of the page on */
const listen = `{ const own = window.AudioContext, make = own.prototype.createBufferSource;
  window.heard = { contexts: 0, peaks: [], spans: [] };
  window.AudioContext = class extends own { constructor(...a) { super(...a); heard.contexts++; heard.context = this; } };
  own.prototype.createBufferSource = function () {
    const s = make.call(this), start = s.start.bind(s);
    s.start = (at) => { heard.peaks.push(s.buffer.getChannelData(0).reduce((m, y) => Math.max(m, Math.abs(y)), 0)); heard.spans.push([at, at + s.buffer.duration]); start(at); };
    return s;
  }; }`;
async function theSound(b) {
  claim("turned off in the address it is silent", await b.evaluate(`heard.contexts === 0 && Page.strokes().list.length > 3`));
  await click(b, await placeOf(b, "sound", 0.5, 0.5));
  await b.until(`document.getElementById("sound").getAttribute("aria-pressed") === "true"`);
  claim("sound is turned on", true);
  const n = await b.evaluate("Page.strokes().list.length");
  await b.evaluate("document.activeElement.blur()");
  await b.key("keyDown", " ", "Space");
  await b.until(`Page.strokes().list.length === ${n + 1} && ${last}.over`);
  await b.key("keyUp", " ", "Space");
  claim("a stroke sounds", await b.evaluate(`heard.contexts === 1 && heard.context.state === "running" && heard.peaks.length >= 1 && heard.peaks[0] > 0.02`),
        await b.evaluate("JSON.stringify([heard.contexts, heard.peaks])"));
  await b.until("heard.spans.length >= 16 && heard.spans.at(-1)[1] - heard.spans[0][0] > 1.5");
  claim("without a gap", await b.evaluate("heard.spans.every((s, i) => i === 0 || i % Math.ceil(1.6 * heard.context.sampleRate / 4096) === 0 || Math.abs(s[0] - heard.spans[i - 1][1]) < 1e-6)"),
        await b.evaluate("JSON.stringify(heard.spans)"));
  await click(b, await placeOf(b, "sound", 0.5, 0.5));
  const tones = await b.evaluate("heard.peaks.length");
  await b.until(`${engine}.armed() && ${engine}.stir() < 2e-3`);
  await tap(b, "l", "KeyL");
  await b.until(`Page.strokes().list.length === ${n + 2} && ${last}.over`);
  await tap(b, "l", "KeyL");
  claim("turned off it is silent", await b.evaluate(`heard.peaks.length === ${tones}`));
}

/* the load at both ends of the stop's way, in real time */
async function manyStrokes(b) {
  await b.evaluate(setSpeed(100));
  claim("the speed is told", await b.evaluate(`document.getElementById("speed-shown").textContent === "real time"`));
  for (const dx of [-1.0, -0.5, 0.15]) {
    await b.evaluate(`(() => { const d = ${engine}.model.dials[0], i = document.getElementById("dial0");
      i.value = 1000 * (${dx}e-3 - d.from) / (d.to - d.from); i.dispatchEvent(new Event("input")); })()`);
    await b.until(`Math.abs(${engine}.value(0) - ${dx}e-3) < 1e-5 && ${engine}.armed() && ${engine}.stir() < 2e-3`);
    const n = await b.evaluate("Page.strokes().list.length");
    await b.evaluate("document.activeElement.blur()");
    await tap(b, "l", "KeyL");
    await b.until(`Page.strokes().list.length === ${n + 1} && ${last}.over`);
    const s = await b.evaluate(last);
    claim(`load at ${dx} mm: on the paper's line`, dx > 0.1 || Math.abs(s.escapeHeight - (2.2e-3 - 20 * dx * 1e-3)) < 1.5e-3,
          1e3 * s.escapeHeight);
    if (dx > 0.1) claim("far to the right: forced", s.escapeTime > s.impactTime, JSON.stringify(s));
    await tap(b, "l", "KeyL");
  }
  claim("each stroke has its row", await b.evaluate(`document.getElementById("table").rows.length === Page.strokes().list.length`));
  const cost = await b.evaluate("Page.perFrame");
  await b.key("keyDown", " ", "Space");
  const rate = await b.evaluate(`new Promise((done) => { let n = 0, t0 = 0;
    const f = (t) => { t0 = t0 || t; if (t - t0 < 500) { n++; requestAnimationFrame(f); } else done(1e3 * n / (t - t0)); };
    requestAnimationFrame(f); })`);
  await b.key("keyUp", " ", "Space");
  await b.until(`${last}.over && ${engine}.armed() && ${engine}.stir() < 2e-3`);
  console.log(`page: a frame of real time takes ${cost.mean.toFixed(1)} ms to simulate (least ${cost.least.toFixed(1)} ms); ${rate.toFixed(0)} frames a second`);
}

async function theHelp(b) {
  await tap(b, "?", "Slash");
  claim("? opens the help", await b.evaluate(`document.getElementById("help").open`));
  claim("in one screen", await b.evaluate(`(() => { const d = document.getElementById("help"); return d.scrollHeight <= d.clientHeight && d.clientHeight < innerHeight; })()`));
  claim("the bits are the library's", await b.evaluate(
    `/same numbers to the last bit/.test(document.getElementById("help-check").textContent)`));
  await look(b, { name: "help" });
  await b.key("keyDown", "Escape", "Escape", 27);
  await b.until(`!document.getElementById("help").open`);
}

/* Tab goes through everything that can be used, in the order of the page, and shows where it is;
 * back is the other way */
async function theFocus(b, back) {
  await b.evaluate(`scrollTo(0, 0); document.activeElement.blur(); getSelection().removeAllRanges();
    window.usable = [...document.querySelectorAll("button, input, select, [tabindex]")].filter((x) => !x.disabled && x.checkVisibility({ visibilityProperty: true }))${back ? ".reverse()" : ""}`);
  const count = await b.evaluate("usable[0].focus({ focusVisible: true }), usable.length"), order = [], hidden = [];
  for (let i = 0; i < count; i++) {
    if (i > 0) {
      await b.key("keyDown", "Tab", "Tab", 9, back);
      await b.key("keyUp", "Tab", "Tab", 9, back);
    }
    const [at, name, outlined, seen] = await b.evaluate(`(() => { const e = document.activeElement, r = e.getBoundingClientRect(), s = document.querySelector(".stage").getBoundingClientRect();
      const under = getComputedStyle(document.querySelector(".stage")).position === "sticky" && !e.closest("header") && r.top < s.bottom - 1 && r.right > s.left && r.left < s.right;
      return [usable.indexOf(e), e.id || e.className, getComputedStyle(e).outlineStyle !== "none", r.bottom > 0 && r.top < innerHeight && !under]; })()`);
    order.push(at);
    if (!outlined || !seen) hidden.push(name);
  }
  claim("Tab goes through the page in its order", count >= 16 && order.every((x, i) => x === i), order);
  claim("what has the focus is marked and in sight", hidden.length === 0, hidden);
  await b.evaluate("document.activeElement.blur(), scrollTo(0, 0)");
}

/* the least contrast of words with what is behind them (WCAG 2: 4.5), and of the sliders (3) */
async function theContrast(b, theme) {
  const [worst, what] = await b.evaluate(`(() => {
    const rgb = (c) => c.match(/[\\d.]+/g).map(Number), opaque = (c) => rgb(c).length < 4 || rgb(c)[3] === 1;
    const lum = (c) => { const [r, g, b] = rgb(c).map((x) => (x /= 255) <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const ratio = (a, b) => { const [x, y] = [lum(a), lum(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
    const behind = (e) => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor; if (opaque(c)) return c; } return "rgb(255, 255, 255)"; };
    let worst = [99, ""];
    const note = (r, what) => { if (r < worst[0]) worst = [r, what]; };
    for (const e of document.querySelectorAll("body *:not(script):not(noscript)"))
      if ([...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()) && e.checkVisibility({ visibilityProperty: true }))
        note(ratio(getComputedStyle(e).color, behind(e)), e.tagName + " " + e.textContent.slice(0, 20));
    const hex = (n) => { const i = document.createElement("i"); i.style.color = "var(--" + n + ")"; document.body.append(i); const c = getComputedStyle(i).color; i.remove(); return c; };
    for (const n of ["track", "brass", "focus", "force", "finger", "tone0", "tone1", "tone2", "tone3"]) note(1.5 * ratio(hex(n), hex("paper")), n);
    return worst;
  })()`);
  claim(`${theme}: words can be read, lines be seen`, worst >= 4.5, [worst, what]);
}

async function everyoneCanReadIt(b) {
  await b.call("Accessibility.enable");
  const { nodes } = await b.call("Accessibility.getFullAXTree");
  const roles = ["button", "slider", "image", "table", "dialog"];
  const nameless = nodes.filter((n) => !n.ignored && roles.includes(n.role?.value) && !n.name?.value && n.role.value !== "table");
  claim("every control has a name", nameless.length === 0, nameless.map((n) => n.role.value));
  const sliders = nodes.filter((n) => !n.ignored && n.role?.value === "slider").length;
  claim("a slider for each number of the regulation, the finger, the speed, the last stroke",
        sliders === 3 + await b.evaluate(`${engine}.model.dials.length`), sliders);
  await theFocus(b);
  await theContrast(b, "light");
  claim("drawing and all sliders are in sight at once", await b.evaluate(
    `scrollTo(0, 0), document.getElementById("stage").getBoundingClientRect().top >= 0 && [...document.querySelectorAll(".dial")].every((d) => d.getBoundingClientRect().bottom <= innerHeight)`));
  const light = await b.evaluate("getComputedStyle(document.body).backgroundColor");
  await look(b, { dark: true, name: "dark" });
  await theContrast(b, "dark");
  claim("dark is dark", light !== await b.evaluate("getComputedStyle(document.body).backgroundColor"));
  await look(b, { width: 360, height: 740, name: "phone" });
  claim("a phone need not scroll sideways", await b.evaluate("document.documentElement.scrollWidth <= innerWidth"));
  claim("nor in the table", await b.evaluate(`(() => { const s = document.querySelector(".scroll"); return document.getElementById("table").rows.length > 8 && s.scrollWidth <= s.clientWidth; })()`));
  await theFocus(b);
  await theFocus(b, true);
  // the last slider moved by a thumb: what it does is in sight
  claim("the drawing stays beside the slider", await b.evaluate(`(() => { const all = document.querySelectorAll(".dial input"), d = all[all.length - 1];
    d.scrollIntoView({ block: "nearest" }); const r = d.getBoundingClientRect(), s = document.querySelector(".stage").getBoundingClientRect();
    return scrollY > 0 && s.top >= 0 && s.bottom <= r.top && r.bottom <= innerHeight; })()`));
  await look(b, { width: 360, height: 740, name: "phone-regulating" });
  await look(b, { width: 360, height: 740, dark: true, name: "phone-dark" });
  const small = await b.evaluate(`[...document.querySelectorAll("button")].filter((x) => x.offsetParent && x.offsetHeight < 36 && !x.closest(".dial")).length`);
  claim("its buttons are as large as a finger", small === 0, small);
}

async function aFinger(b) {
  await look(b, { width: 360, height: 740, name: "phone-again" });
  await tap(b, "r", "KeyR");
  const n = await b.evaluate("Page.strokes().list.length");
  const at = await b.evaluate(`(() => { scrollTo(0, 0); const r = document.getElementById("stage").getBoundingClientRect(); return [r.left + 0.94 * r.width, r.top + 0.8 * r.height]; })()`);
  await b.call("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ x: at[0], y: at[1] }] });
  await b.until(`Page.strokes().list.length === ${n + 1} && ${last}.impacts > 0`);
  await b.call("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  claim("a finger on the drawing strikes", true);
  await b.until(`${last}.over`);
}

/* what is neither key nor hammer: it starts, moves or waits, turns its dials, and has its own
 * title */
async function another(b, page) {
  const name = path.basename(page, ".html");
  await b.call("Page.navigate", { url: address(page) });
  await b.until(`document.documentElement?.dataset.ready !== undefined && Page.engine()?.model.name === "${name}"`);
  claim(`${name}: starts`, await b.evaluate(`document.documentElement.dataset.ready === "yes" && document.getElementById("failure").hidden`));
  claim(`${name}: is no piano`, await b.evaluate(`document.getElementById("strokes").hidden && document.getElementById("chart-section").hidden && document.getElementById("sound").hidden`));
  claim(`${name}: traces what there is`, await b.evaluate(`(document.getElementById("traces").offsetParent === null) === (${engine}.model.channels.length === 1)`));
  await tap(b, "r", "KeyR");
  const held = await b.evaluate(`${engine}.model.inputs.some((k) => k.kind !== "motion")`);
  if (held) await b.key("keyDown", " ", "Space");
  await b.until(`${engine}.time() > 0.02`);
  await b.evaluate(`document.getElementById("dial0").focus()`);
  const was = await b.evaluate(`${engine}.value(${engine}.model.dials[0].param)`);
  await tap(b, "ArrowRight", "ArrowRight");
  await b.until(`${engine}.value(${engine}.model.dials[0].param) > ${was}`);
  if (held) await b.key("keyUp", " ", "Space");
  await tap(b, "?", "Slash");
  claim(`${name}: the bits are the library's`, await b.evaluate(`/same numbers to the last bit/.test(document.getElementById("help-check").textContent)`));
  await look(b, { name });
}

async function run() {
  const b = await open(program), asked = [], broken = [];
  b.on((method, p) => {
    if (method === "Network.requestWillBeSent") asked.push(p.request.url.slice(0, 60));
    if (method === "Runtime.exceptionThrown") broken.push(p.exceptionDetails.exception?.description);
  });
  try {
    await look(b, { name: "blank" });
    await b.call("Page.addScriptToEvaluateOnNewDocument", { source: listen });
    await b.call("Page.navigate", { url: address(file) + "#sound=off" });
    await b.until(`document.documentElement?.dataset.ready !== undefined`);
    claim("it starts from disk", await b.evaluate(`document.documentElement.dataset.ready === "yes"`),
          await b.evaluate(`document.getElementById("failure").textContent`));
    await look(b, { name: "rest" });
    await whatIsShown(b);
    await aSlowStroke(b);
    await everyDial(b);
    await aMouse(b);
    await theSound(b);
    await manyStrokes(b);
    await look(b, { name: "strokes" });
    await theHelp(b);
    await everyoneCanReadIt(b);
    await aFinger(b);
    for (const page of others) await another(b, page);
    claim("it asked for nothing but itself",
          asked.every((u) => u.startsWith("file:") || u.startsWith("data:")), asked);
    claim("no script failed", broken.length === 0, broken);
  } catch (e) {
    claim(`the browser's part runs through (${e.message})`, false);
  }
  await b.close();
  console.log(`${count.passed} ${count.failed}`);
}

run().catch((e) => { console.log(`FAILED: ${e.stack}`); console.log("0 1"); });
