/* SPDX-License-Identifier: MIT
 * views_test.js - directions to look from, closed loops, names in the drawing and sound on the first
 * press, in Chromium. Prints failures and "PASSED FAILED".
 *
 *   node views_test.js CHROMIUM ACTION SPATIAL LOOP RODS ROAMING    pages of mechanisms */
"use strict";

const path = require("path");
const { open } = require("./browser.js");
const { claim, count } = require("./page_file.js");

const [program, action, spatial, loop, rods, roaming] = process.argv.slice(2);
const engine = "Page.engine()", geometry = "Page.geometry()";
const width = (b, w) => b.call("Emulation.setDeviceMetricsOverride", { width: w, height: 800, deviceScaleFactor: 1, mobile: w < 600 });
const pressed = (b, id) => b.evaluate(`document.getElementById("${id}").getAttribute("aria-pressed") === "true"`);
const picture = (b) => b.evaluate(`document.getElementById("stage").toDataURL()`);

async function go(b, file, hash = "") {
  await b.call("Page.navigate", { url: "about:blank" });
  await b.call("Page.navigate", { url: "file://" + path.resolve(file) + hash });
  await b.until(`document.documentElement?.dataset.ready !== undefined`);
}
async function tap(b, key, code) {
  await b.key("keyDown", key, code);
  await b.key("keyUp", key, code);
}
/* how many pixels of the drawing have a colour of the page's style */
const pixels = (b, colour) => b.evaluate(`(() => { const i = document.createElement("i"); i.style.color = "var(--${colour})"; document.body.append(i);
  const [r, g, b] = getComputedStyle(i).color.match(/\\d+/g).map(Number), c = document.getElementById("stage"); i.remove();
  const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let k = 0; k < d.length; k += 4) n += Math.abs(d[k] - r) + Math.abs(d[k + 1] - g) + Math.abs(d[k + 2] - b) < 8 && d[k + 3] > 200;
  return n; })()`);
/* the places of a mechanism on the canvas: are all of them on it? */
const inside = (b) => b.evaluate(`(() => { const c = document.getElementById("stage"), g = ${geometry}; g.place(${engine}.q());
  return g.places().map((p) => Page.scene().to(g.project(p))).every(([x, y]) => x >= 0 && y >= 0 && x <= c.clientWidth && y <= c.clientHeight); })()`);

/* variances of all places over the run, seen from each side */
const motion = `(() => { const e = ${engine}, g = ${geometry}, sums = {}; e.reset();
  const runs = []; for (let n = 0; n < 100; n++) { g.place(e.q()); runs.push(g.places()); e.advance(Math.round(e.model.until / e.model.dt / 100)); }
  const variance = (i, k) => { const v = runs.map((r) => r[i][k]), m = v.reduce((a, b) => a + b) / v.length; return v.reduce((a, b) => a + (b - m) ** 2, 0); };
  const all = [0, 1, 2].map((k) => runs[0].reduce((s, _, i) => s + variance(i, k), 0));
  return { front: all[0] + all[2], side: all[1] + all[2], top: all[0] + all[1] }; })()`;

async function directions(b) {
  await go(b, spatial);
  const view = () => b.evaluate(`document.getElementById("view").value`);
  claim("a mechanism with a depth has a choice of directions", await b.evaluate(`!document.getElementById("view-choice").hidden && document.getElementById("view").options.length === 4`));
  const first = await view();
  await tap(b, "p", "KeyP");
  const seen = await b.evaluate(motion);
  claim("it is seen from where most of it moves", seen[first] === Math.max(...Object.values(seen)), [first, JSON.stringify(seen)]);
  await tap(b, "r", "KeyR");
  await tap(b, "p", "KeyP");
  const pictures = new Set();
  for (const name of ["front", "side", "top", "oblique"]) {
    await b.evaluate(`(() => { const s = document.getElementById("view"); s.value = "${name}"; s.dispatchEvent(new Event("change")); })()`);
    claim(`${name}: all of it is on the drawing`, await inside(b));
    claim(`${name}: a link has it`, (await b.evaluate("location.hash")).includes("view=") === (name !== first), await b.evaluate("location.hash"));
    pictures.add(await picture(b));
  }
  claim("the directions differ", pictures.size === 4);
  await go(b, spatial, "#view=top");
  claim("the address chooses one", await view() === "top");
  const p = await b.evaluate(`(() => { const g = ${geometry}, q = g.places().at(-1); return [g.project(q), q]; })()`);
  claim("from above x is right and y is up", p[0][0] === p[1][0] && p[0][1] === p[1][1], JSON.stringify(p));
  await go(b, spatial, "#view=nowhere");
  claim("a direction that there is not is passed over", await view() === first);
  await go(b, loop, "#view=top");
  claim("a plane mechanism has no choice", await b.evaluate(`document.getElementById("view-choice").offsetParent === null`) &&
        await b.evaluate(`(() => { const q = ${geometry}.places().at(-1), p = ${geometry}.project(q); return p[0] === q[0] && p[1] === q[2]; })()`));
}

async function loops(b) {
  await go(b, loop);
  const ends = await b.evaluate(`${engine}.model.loops.map((l) => [l.from, l.to].map((i) => { const p = ${engine}.model.points[i]; return Page.scene().to(${geometry}.at(p.body, ${geometry}.vec(p.at))); }))`);
  claim("a loop is closed in the drawing", ends.length === 1 && ends.every(([p, q]) => Math.hypot(p[0] - q[0], p[1] - q[1]) < 0.01), JSON.stringify(ends));
  const names = await picture(b);
  claim("a body of one place is drawn", await pixels(b, "wood3") > 50, await pixels(b, "wood3"));
  await go(b, rods);
  const kinds = await b.evaluate(`${engine}.model.loops.map((l) => l.kind).join(" ")`);
  claim("rods and slots are drawn", kinds === "rod slot" && await pixels(b, "frame") > 200, [kinds, await pixels(b, "frame")]);
  claim("the pages differ", names !== await picture(b));
}

async function names(b) {
  for (const w of [390, 1100]) {
    await width(b, w);
    for (const page of [action, loop]) {
      await go(b, page, "#speed=0");
      const calm = await pixels(b, "muted");
      await b.key("keyDown", " ", "Space");
      await b.until(`${engine}.time() > 1e-4 && document.getElementById("stage").isConnected`);
      const moving = await pixels(b, "muted");
      await tap(b, "p", "KeyP");
      const paused = await pixels(b, "muted");
      await b.key("keyUp", " ", "Space");
      claim(`${path.basename(page)}, ${w} px: names stand at it until it moves, and when it is paused`, calm > moving + 30 && paused > moving + 30, [calm, moving, paused]);
      claim(`${path.basename(page)}, ${w} px: nothing is wider than the window`, await b.evaluate("document.documentElement.scrollWidth") <= w);
    }
  }
}

async function roams(b) {
  await width(b, 800);
  await go(b, roaming);
  for (const t of [0.1, 0.3, 0.6]) {
    await b.until(`${engine}.time() > ${t}`);
    await tap(b, "p", "KeyP");
    claim(`after ${t} s a falling mechanism is on the drawing`, await inside(b));
    await tap(b, "p", "KeyP");
  }
}

async function sound(b) {
  await width(b, 1100);
  await go(b, action);
  claim("before it is touched it is silent", !(await pressed(b, "sound")));
  await b.key("keyDown", " ", "Space");
  await b.until(`document.getElementById("sound").getAttribute("aria-pressed") === "true"`);
  await b.key("keyUp", " ", "Space");
  claim("the first press turns the sound on", await b.evaluate(`document.getElementById("sound").textContent`) === "Sound on");
  await b.evaluate(`document.getElementById("sound").click()`);
  await b.until(`document.getElementById("sound").getAttribute("aria-pressed") === "false"`);
  claim("turned off, a link says so", (await b.evaluate("location.hash")).includes("sound=off"));
  await go(b, action, "#sound=off");
  await tap(b, "l", "KeyL");
  await b.until("Page.strokes().list.length > 0 && Page.strokes().list.at(-1).impacts > 0");
  claim("and it stays off", !(await pressed(b, "sound")));
}

async function run() {
  const b = await open(program), broken = [];
  b.on((method, p) => { if (method === "Runtime.exceptionThrown") broken.push(p.exceptionDetails.exception?.description); });
  try {
    await width(b, 1100);
    await directions(b);
    await loops(b);
    await names(b);
    await roams(b);
    await sound(b);
    claim("no script failed", broken.length === 0, broken);
  } catch (e) {
    claim(`the views' part runs through (${e.message})`, false);
  }
  await b.close();
  console.log(`${count.passed} ${count.failed}`);
}

run().catch((e) => { console.log(`FAILED: ${e.stack}`); console.log("0 1"); });
