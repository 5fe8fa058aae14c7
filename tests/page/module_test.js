/* SPDX-License-Identifier: MIT
 * module_test.js - a page without a browser: the file, the module in it, its numbers against the
 * native ones, and that a turned dial pushes nothing. Prints failures and "PASSED FAILED".
 *
 *   node module_test.js PAGE SHIM.c [STROKE.json]      STROKE.json: stein strike --json of it */
"use strict";

const fs = require("fs");
const { read, paceOf, claim, count } = require("./page_file.js");

const [file, shim, stroke] = process.argv.slice(2);
const page = read(file), { model } = page, name = model.name;

function theFile() {
  const size = fs.statSync(file).size;
  claim(`${name}: the page is under 400 KB`, size < 400e3, size);
  claim(`${name}: no address of a network`, !/https?:\/\/|wss?:\/\//.test(page.html));
  const loads = page.html.match(/\b(src|href)="(?!data:)[^"]*"|@import|url\((?!data:)|\bfetch\(|XMLHttpRequest|importScripts|\bimport\(/g);
  claim(`${name}: nothing is loaded`, loads === null, loads);
  claim(`${name}: no mark of a part is left`, !/^@\w+@$/m.test(page.html));
}

function theModule() {
  const module = new WebAssembly.Module(Buffer.from(page.module, "base64"));
  claim(`${name}: the module imports nothing`, WebAssembly.Module.imports(module).length === 0);
  const wanted = [...fs.readFileSync(shim, "utf8").matchAll(/^EXPORT\((\w+)\)/gm)].map((m) => m[1]);
  const found = WebAssembly.Module.exports(module).map((e) => e.name).filter((n) => n !== "memory");
  claim(`${name}: it exports the calls of shim.c`, wanted.length > 20 &&
        wanted.sort().join() === found.sort().join(), found);
}

/* gaps as the page draws them against those of the contacts' equations, along a motion */
function theDrawing(engine) {
  const g = page.Geometry.create(model);
  const gaps = model.channels.map((c, i) => ({ ...c, i }))
    .filter((c) => c.read === "gap" && !c.rest && model.contacts[c.index].spots.length === 1);
  let worst = 0, points = 0;
  const places = model.channels.map((c, i) => ({ ...c, i }))
    .filter((c) => "xyz".includes(c.read) && !c.rest);
  for (let n = 0; n < 50; n++) {
    engine.advance(Math.max(1, Math.round(0.6 * model.until / model.dt / 50)));
    g.place(engine.q());
    const now = engine.channels();
    for (const c of gaps)
      worst = Math.max(worst, Math.abs(g.spot(model.contacts[c.index].spots[0]).gap - c.sign * now[c.i]));
    for (const c of places) {
      const p = model.points[c.index], k = g.plane.indexOf("xyz".indexOf(c.read));
      if (k < 0) continue;
      points++;
      worst = Math.max(worst, Math.abs(g.at(p.body, g.vec(p.at))[k] - c.sign * now[c.i]));
    }
  }
  claim(`${name}: what is drawn is where the equations have it`, worst < 1e-12, worst);
  return gaps.length > 0 || points > 0;
}

function theStroke(engine) {
  const native = JSON.parse(fs.readFileSync(stroke, "utf8"));
  engine.reset();
  engine.beginStroke();
  engine.advance(Math.round(model.until / model.dt));
  const s = engine.stroke();
  claim("escapement: time and height as natively", s.escapeTime === native.escapement.time &&
        s.escapeHeight === native.escapement.height, JSON.stringify(s));
  claim("impact: time and speed as natively", s.impactTime === native.impact.time &&
        s.impactSpeed === native.impact.speed && s.impacts === native.impacts, JSON.stringify(s));
  claim("peak force as natively, between steps", s.peak <= native.peak_string_force &&
        s.peak > 0.9999 * native.peak_string_force, `${s.peak} ${native.peak_string_force}`);
  claim("it is called by its name", page.Strokes.outcome(s) === "struck");
  const pulse = engine.pulse();
  claim("the string's force is told once", pulse !== null && engine.pulse() === null);
  claim("from the impact on", pulse && pulse.some((f) => f > 0.99 * s.peak) &&
        pulse[pulse.length - 1] === 0);
  theTone(pulse);
}

/* energy of a tone at a frequency */
function at(tone, f, rate) {
  let [re, im] = [0, 0];
  tone.forEach((y, i) => { const w = 2 * Math.PI * f * i / rate; re += y * Math.cos(w); im += y * Math.sin(w); });
  return Math.hypot(re, im);
}
function theTone(pulse) {
  const rate = 48000, tone = page.Sound.tone(pulse, model.dt, rate);
  const loud = (from, to) => tone.slice(from, to).reduce((m, y) => Math.max(m, Math.abs(y)), 0);
  claim("it sounds, and not too loud", loud(0, 4800) > 0.02 && loud(0, 4800) < 1, loud(0, 4800));
  claim("and dies away", loud(tone.length - 4800) < 0.1 * loud(0, 4800));
  claim("at F6", at(tone, 1397, rate) > 20 * at(tone, 1250, rate));
  const twice = page.Sound.tone(pulse.map((f) => 2 * f), model.dt, rate);
  claim("twice the force is twice the tone", Math.abs(twice[999] - 2 * tone[999]) < 1e-5);
}

/* largest change of a joint's speed in one step, from a saved motion with something done to it */
function shove(engine, begin, act, steps) {
  engine.reset();
  engine.advance(begin);
  act();
  let most = 0, before = engine.q().slice(), v = null;
  for (let n = 0; n < steps; n++) {
    engine.advance(1);
    const q = engine.q().slice(), now = q.map((x, j) => (x - before[j]) / model.dt);
    if (v) now.forEach((x, j) => { if (!model.bodies[j].load) most = Math.max(most, Math.abs(x - v[j])); });
    [before, v] = [q, now];
  }
  return most;
}

function theDials(engine) {
  const string = model.channels.findIndex((c) => c.name === "string_force");
  engine.reset();
  let struck = 0;
  while (engine.channels()[string] < 3) { engine.advance(1); struck++; }
  const own = shove(engine, struck, () => {}, 200), turned = [];
  for (const d of model.dials) {
    const value = model.values[d.param], far = d.to - value > value - d.from ? d.to : d.from;
    const slow = shove(engine, struck, () => engine.aim(d.param, far, paceOf(page.html, d)), 200);
    engine.aim(d.param, value, 0);
    turned.push([d.name, slow / own]);
  }
  const worst = turned.reduce((a, b) => (b[1] > a[1] ? b : a));
  claim("no dial that is turned in the blow shoves more than the blow itself", worst[1] < 1.2, worst);
  const h = model.dials.find((d) => d.name === "string.height");
  const jump = shove(engine, struck, () => engine.aim(h.param, h.from, 0), 200);
  engine.aim(h.param, model.values[h.param], 0);
  claim("a jump of the string would", jump > 10 * own, jump / own);
  engine.reset();
  engine.aim(h.param, h.from, paceOf(page.html, h));
  engine.advance(100);
  const moved = model.values[h.param] - engine.value(h.param);
  claim("a dial is on its way for some time", moved > 0 && moved < 0.2 * (model.values[h.param] - h.from), moved);
  engine.advance(8000);
  claim("and arrives", engine.value(h.param) === h.from);
  engine.aim(h.param, model.values[h.param], 0);
}

function theFinger(engine) {
  const finger = model.inputs.findIndex((i) => i.name === "finger");
  engine.reset();
  engine.load(false);
  claim("the load can be taken away", !engine.loadPresent());
  engine.beginStroke();
  engine.push(finger, 0.7, 90);
  engine.advance(20000);
  claim("a finger strikes", page.Strokes.outcome(engine.stroke()) === "struck");
  engine.push(finger, 0, 90);
  engine.advance(60000);
  claim("released, it is ready again and at rest", engine.armed() && engine.stir() < 2e-3, engine.stir());
  engine.load(true);
  engine.beginStroke();
  engine.advance(20000);
  claim("the load that is put back strikes too", page.Strokes.outcome(engine.stroke()) === "struck");
}

async function run() {
  theFile();
  theModule();
  const engine = await page.Engine.create(page.module, model, 10);
  const here = engine.verify();
  claim(`${name}: the state after its own run is the native one`, here === model.hash, here);
  const drawn = theDrawing(engine);
  if (stroke) {
    claim("there are gaps and points to compare", drawn);
    theStroke(engine);
    theDials(engine);
    theFinger(engine);
  }
  console.log(`${count.passed} ${count.failed}`);
}

run().catch((e) => { console.log(`FAILED: ${name}: ${e.stack}`); console.log("0 1"); });
