/* SPDX-License-Identifier: MIT
 * browser_test.js - the page in Chromium, opened from disk: played by keys, regulated in the middle
 * of a stroke, read. Prints failures, what a frame costs, and "PASSED FAILED".
 *
 *   node browser_test.js CHROMIUM PAGE [PICTURE-FOLDER] */
"use strict";

const fs = require("fs");
const path = require("path");
const { open } = require("./browser.js");
const { claim, count } = require("./page_file.js");

const [program, file, pictures] = process.argv.slice(2);
const url = "file://" + path.resolve(file);
const engine = "Page.engine()", last = "Page.strokes().list.at(-1)";
const cell = (i) => `document.querySelector("#table tr").cells[${i}].textContent`;

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
  claim("it is told once, in words", await b.evaluate(
    `document.querySelectorAll("[aria-live]").length === 1 && /^Stroke 1: .* newtons\\.$/.test(document.getElementById("announce").textContent)`));
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
  const cost = await b.evaluate("Page.perFrame");
  console.log(`page: a frame of real time takes ${cost.mean.toFixed(1)} ms to simulate (least ${cost.least.toFixed(1)} ms)`);
}

async function theHelp(b) {
  await tap(b, "?", "Slash");
  claim("? opens the help", await b.evaluate(`document.getElementById("help").open`));
  claim("the bits are the library's", await b.evaluate(
    `/same numbers to the last bit/.test(document.getElementById("help-check").textContent)`));
  await look(b, { name: "help" });
  await b.call("Input.dispatchKeyEvent", { type: "keyDown", key: "Escape", code: "Escape", windowsVirtualKeyCode: 27 });
  await b.until(`!document.getElementById("help").open`);
}

async function everyoneCanReadIt(b) {
  await b.call("Accessibility.enable");
  const { nodes } = await b.call("Accessibility.getFullAXTree");
  const roles = ["button", "slider", "image", "table", "dialog"];
  const nameless = nodes.filter((n) => !n.ignored && roles.includes(n.role?.value) && !n.name?.value && n.role.value !== "table");
  claim("every control has a name", nameless.length === 0, nameless.map((n) => n.role.value));
  claim("there are controls", nodes.filter((n) => n.role?.value === "slider").length >= 10);
  const light = await b.evaluate("getComputedStyle(document.body).backgroundColor");
  await look(b, { dark: true, name: "dark" });
  claim("dark is dark", light !== await b.evaluate("getComputedStyle(document.body).backgroundColor"));
  await look(b, { width: 360, height: 740, name: "phone" });
  claim("a phone need not scroll sideways", await b.evaluate("document.documentElement.scrollWidth <= innerWidth"));
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

async function run() {
  const b = await open(program), asked = [], broken = [];
  b.on((method, p) => {
    if (method === "Network.requestWillBeSent") asked.push(p.request.url.slice(0, 60));
    if (method === "Runtime.exceptionThrown") broken.push(p.exceptionDetails.exception?.description);
  });
  try {
    await look(b, { name: "blank" });
    await b.call("Page.navigate", { url });
    await b.until(`document.documentElement?.dataset.ready !== undefined`);
    claim("it starts from disk", await b.evaluate(`document.documentElement.dataset.ready === "yes"`),
          await b.evaluate(`document.getElementById("failure").textContent`));
    await look(b, { name: "rest" });
    await aSlowStroke(b);
    await manyStrokes(b);
    await look(b, { name: "strokes" });
    await theHelp(b);
    await everyoneCanReadIt(b);
    await aFinger(b);
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
