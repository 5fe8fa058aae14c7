/* SPDX-License-Identifier: MIT
 * preview.js - what the mechanism does before anyone touches it: its own run, for the box of the
 * drawing, the travel of contacts, guides of what slides, and the ranges of the traces. */
"use strict";

const Preview = (() => {
  function tangentOf(geometry, pair) { // where along the line of a contact the other side is
    const s = geometry.spot(pair);
    if (!s.b.n) return 0;
    return (s.at[0] - s.b.at[0]) * s.b.t[0] + (s.at[1] - s.b.at[1]) * s.b.t[1];
  }

  function run({ model, engine, geometry, scene, traces }) {
    const steps = Math.min(Math.round(model.until / model.dt), 40000), looks = 160;
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    const travel = model.contacts.map((c) => c.spots.map(() => [Infinity, -Infinity]));
    const centres = model.bodies.map(() => null), guides = model.bodies.map(() => null);
    const include = (p, r = 0) => {
      [box[0], box[1]] = [Math.min(box[0], p[0] - r), Math.min(box[1], p[1] - r)];
      [box[2], box[3]] = [Math.max(box[2], p[0] + r), Math.max(box[3], p[1] + r)];
    };
    const look = () => {
      geometry.place(engine.q());
      traces.learn(engine.trace());
      model.bodies.forEach((b, i) => {
        if (b.load) return;
        const o = geometry.local(i, 0, 0);
        include(o);
        include(geometry.at(i, geometry.vec(b.centre)));
        centres[i] = centres[i] || o;
        const slides = (k) => model.bodies[k]?.type === "T";
        const alone = !slides(b.parent) && !model.bodies.some((c, k) => c.parent === i && slides(k));
        if (b.type === "T" && alone) guides[i] = [centres[i], o];
      });
      model.points.forEach((p) => include(geometry.at(p.body, geometry.vec(p.at))));
      model.notches.forEach((k) => { const n = geometry.notch(k); include(n.corner); });
      model.contacts.forEach((c, i) => c.spots.forEach((pair, k) => {
        const s = geometry.spot(pair), t = tangentOf(geometry, pair), r = travel[i][k];
        travel[i][k] = [Math.min(r[0], t), Math.max(r[1], t)];
        if (!c.load) include(s.a.at, s.a.radius || 0);
        if (!c.load && !s.b.n) include(s.b.at, s.b.radius);
        if (i === model.string) include([s.a.at[0], s.b.at[1]]);
      }));
    };
    engine.reset();
    look();
    for (let n = 0; n < looks; n++) {
      engine.advance(Math.max(1, Math.round(steps / looks)));
      look();
    }
    const size = Math.max(box[2] - box[0], box[3] - box[1], 0.02);
    const room = (scene.action ? 0.02 : 0.25) * size;
    for (const side of [0, 1]) // flat things need air
      if (box[side + 2] - box[side] < 0.3 * size) {
        const add = (0.3 * size - (box[side + 2] - box[side])) / 2;
        box[side] -= add;
        box[side + 2] += add;
      }
    travel.forEach((c) => c.forEach((r) => { r[0] -= room; r[1] += room; }));
    scene.learn({ box, travel, guides: guides.filter((k) => k) });
  }

  return { run };
})();
