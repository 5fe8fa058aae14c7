/* SPDX-License-Identifier: MIT
 * module_test.js - a page without a browser: the file, the module in it, its numbers against the
 * native ones, and that a turned dial pushes nothing. Prints failures and "PASSED FAILED".
 *
 *   node module_test.js PAGE SHIM.c [STROKE.json CHECK.json]    stein strike, check --json of it */
"use strict";

const fs = require("fs");
const { read, paceOf, claim, count } = require("./page_file.js");

const [file, shim, stroke, facts] = process.argv.slice(2);
const page = read(file), { model } = page, name = model.name;

function theFile() {
  claim(`${name}: no address of a network`, !/https?:\/\/|wss?:\/\//.test(page.html));
  const loads = page.html.match(/\b(src|href)="(?!data:)[^"]*"|@import|url\((?!data:)|\bfetch\(|XMLHttpRequest|importScripts|\bimport\(/g);
  claim(`${name}: nothing is loaded`, loads === null, loads);
  claim(`${name}: there is something to turn, each to both sides`, model.dials.length >= 3 &&
        model.dials.every((d) => d.from <= model.values[d.param] && model.values[d.param] <= d.to && d.from < d.to));
  claim(`${name}: no mark of a part is left`, !/^@\w+@$/m.test(page.html));
}

/* exactly the numbers of the file's regulation have a dial */
function theRegulation() {
  const wanted = JSON.parse(fs.readFileSync(facts, "utf8")).regulation;
  const row = (d) => [d.name, d.label, d.from, d.to].join();
  claim("a dial for every number of the regulation", wanted.length >= 9 &&
        wanted.map(row).join(";") === model.dials.map(row).join(";"), model.dials.map(row));
}

function theModule() {
  const module = new WebAssembly.Module(Buffer.from(page.module, "base64"));
  claim(`${name}: the module imports nothing`, WebAssembly.Module.imports(module).length === 0);
  const wanted = [...fs.readFileSync(shim, "utf8").matchAll(/^EXPORT\((\w+)\)/gm)].map((m) => m[1]);
  const found = WebAssembly.Module.exports(module).map((e) => e.name).filter((n) => n !== "memory");
  claim(`${name}: it exports the calls of shim.c`, wanted.length > 20 &&
        wanted.sort().join() === found.sort().join(), found);
}

/* gaps in the drawing against gaps by the contacts' equations, along a motion */
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
      const p = model.points[c.index], k = "xyz".indexOf(c.read);
      points++;
      worst = Math.max(worst, Math.abs(g.world(p.body, g.vec(p.at))[k] - c.sign * now[c.i]));
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
  const rate = 48000, whole = (p) => [...page.Sound.pieces(p, model.dt, rate)].flatMap((x) => [...x]);
  const tone = whole(pulse);
  claim("for 1.6 s", tone.length === 1.6 * rate);
  // where pieces meet, it goes on: a sample from the two before, mode by mode, is a recurrence
  const step = (i) => Math.abs(tone[i + 1] - 2 * tone[i] + tone[i - 1]);
  const inside = Math.max(...[...Array(4000).keys()].map((i) => step(i + 80)));
  claim("without seams", step(4095) <= inside && step(4096) <= inside && step(8192) <= inside, [step(4095), step(4096), inside]);
  const loud = (from, to) => tone.slice(from, to).reduce((m, y) => Math.max(m, Math.abs(y)), 0);
  claim("it sounds, and not too loud", loud(0, 4800) > 0.02 && loud(0, 4800) < 1, loud(0, 4800));
  claim("and dies away", loud(tone.length - 4800) < 0.1 * loud(0, 4800));
  claim("at F6", at(tone, 1397, rate) > 20 * at(tone, 1250, rate));
  const twice = whole(pulse.map((f) => 2 * f));
  claim("twice the force is twice the tone", Math.abs(twice[999] - 2 * tone[999]) < 1e-5);
}

/* largest change of a joint's speed in one step, from a saved motion with something done to it */
function shove(engine, begin, act, steps, load = true) {
  engine.reset();
  engine.load(load);
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
  const own = shove(engine, struck, () => {}, 200), slow = [], jump = [];
  // at rest on the stop; the beak on the corner; the head in the string; the key down, hammer caught
  for (const begin of [0, Math.round(0.8 * struck), struck, 12000]) {
    const quiet = shove(engine, begin, () => {}, 200);
    for (const d of model.dials) {
      for (const end of [d.from, d.to]) {
        const more = (pace) => {
          const most = shove(engine, begin, () => engine.aim(d.param, end, pace), 200) - quiet;
          engine.aim(d.param, model.values[d.param], 0);
          return most / own;
        };
        slow.push([d.name, begin, more(paceOf(page.html, d))]);
        jump.push([d.name, begin, more(0)]);
      }
    }
  }
  const worst = slow.reduce((a, b) => (b[2] > a[2] ? b : a));
  const worstJump = jump.reduce((a, b) => (b[2] > a[2] ? b : a));
  claim("no dial that is turned shoves like a blow", worst[2] < 0.2, worst);
  claim("one that jumps would", worstJump[2] > 1 && worstJump[2] > 5 * worst[2], worstJump);
  // all the way, with everything lying in its place
  const calm = model.dials.flatMap((d) => [d.from, d.to].map((end) => {
    const most = shove(engine, 100, () => engine.aim(d.param, end, paceOf(page.html, d)), 6200, false);
    const there = engine.value(d.param) === end;
    engine.aim(d.param, model.values[d.param], 0);
    return [d.name, there, most / own];
  }));
  const worstCalm = calm.reduce((a, b) => (b[2] > a[2] ? b : a));
  claim("at rest they are felt as hands", calm.every((c) => c[1]) && worstCalm[2] > 0 && worstCalm[2] < 0.05, worstCalm);
  engine.load(true);
  const h = model.dials.find((d) => d.name === "string.height");
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

/* all dials, the finger and the load at random: it goes on, and comes back to rest */
function theWildHand(engine) {
  const finger = model.inputs.findIndex((i) => i.name === "finger");
  let seed = 1788;
  const random = () => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;
  engine.reset();
  for (let n = 0; n < 100; n++) {
    const d = model.dials[Math.floor(random() * model.dials.length)];
    if (random() < 0.7) engine.aim(d.param, d.from + random() * (d.to - d.from), paceOf(page.html, d));
    if (random() < 0.4) engine.push(finger, random() < 0.5 ? 0 : 4 * random(), 100);
    if (random() < 0.2) engine.load(!engine.loadPresent());
    engine.advance(500 + Math.floor(1500 * random()));
  }
  claim("a wild hand breaks nothing", engine.q().every(Number.isFinite));
  for (const d of model.dials) engine.aim(d.param, model.values[d.param], paceOf(page.html, d));
  engine.push(finger, 0, 100);
  engine.load(false);
  engine.advance(80000);
  claim("and leaves it ready and at rest", engine.armed() && engine.stir() < 2e-3, engine.stir());
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
    theRegulation();
    theStroke(engine);
    theDials(engine);
    theFinger(engine);
    theWildHand(engine);
  }
  console.log(`${count.passed} ${count.failed}`);
}

run().catch((e) => { console.log(`FAILED: ${name}: ${e.stack}`); console.log("0 1"); });
