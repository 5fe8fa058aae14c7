/* SPDX-License-Identifier: MIT
 * preview.js - a run of the mechanism without a user. It gives the directions of view and the box
 * of the drawing in each, the travel of contacts, guides of sliding bodies, and the ranges of the
 * traces. */
"use strict";

const Preview = (() => {
  const flat = 1e-6;   // of the size of a mechanism: less is no depth
  const roaming = 2.5; // so much larger than at the start is a mechanism that leaves its place

  function tangentOf(geometry, pair) { // where along the line of a contact the other side is
    const s = geometry.spot(pair);
    if (!s.b.n) return 0;
    return (s.at[0] - s.b.at[0]) * s.b.t[0] + (s.at[1] - s.b.at[1]) * s.b.t[1];
  }

  const emptyBox = () => [Infinity, Infinity, -Infinity, -Infinity];
  function include(box, p, r = 0) {
    [box[0], box[1]] = [Math.min(box[0], p[0] - r), Math.min(box[1], p[1] - r)];
    [box[2], box[3]] = [Math.max(box[2], p[0] + r), Math.max(box[3], p[1] + r)];
  }
  const sizeOf = (box) => Math.max(box[2] - box[0], box[3] - box[1], 0.02);

  /* flat things need air */
  function widen(box) {
    const size = sizeOf(box);
    for (const side of [0, 1])
      if (box[side + 2] - box[side] < 0.3 * size) {
        const add = (0.3 * size - (box[side + 2] - box[side])) / 2;
        box[side] -= add;
        box[side + 2] += add;
      }
    return box;
  }

  /* motion of all places along x, y, z, and how far they extend */
  function spreads(runs) {
    const motion = [0, 0, 0], low = [Infinity, Infinity, Infinity], high = low.map((v) => -v);
    runs[0].forEach((_, i) => {
      for (let k = 0; k < 3; k++) {
        const v = runs.map((r) => r[i][k]), mean = v.reduce((a, b) => a + b) / v.length;
        motion[k] += v.reduce((a, b) => a + (b - mean) ** 2, 0) / v.length;
        low[k] = Math.min(low[k], ...v);
        high[k] = Math.max(high[k], ...v);
      }
    });
    return { motion, extent: high.map((h, k) => h - low[k]) };
  }

  /* the direction from which most of the motion is seen, and whether another one shows more */
  function directions({ motion, extent }, views) {
    if (views.length === 1) return { view: views[0], spatial: false };
    const score = motion.map((m, k) => m + 1e-3 * extent[k] ** 2);
    const hidden = [1, 0, 2].reduce((a, k) => (score[k] < score[a] ? k : a));
    return { view: ["side", "front", "top"][hidden],
             spatial: extent.every((e) => e > flat * Math.max(...extent)) };
  }

  function run({ model, engine, geometry, scene, traces }) {
    const steps = Math.min(Math.round(model.until / model.dt), 40000), looks = 160;
    const travel = model.contacts.map((c) => c.spots.map(() => [Infinity, -Infinity]));
    const guides = model.bodies.map(() => null); // ends of the way of what slides, and q there
    const runs = [], contacts = emptyBox();
    const look = () => {
      const q = engine.q();
      geometry.place(q);
      traces.learn(engine.trace());
      runs.push(geometry.places());
      model.bodies.forEach((b, i) => {
        if (b.load) return;
        const slides = (k) => model.bodies[k]?.type === "T";
        const alone = !slides(b.parent) && !model.bodies.some((c, k) => c.parent === i && slides(k));
        if (b.type !== "T" || !alone) return;
        const o = geometry.world(i, [0, 0, 0]), way = guides[i] || [[q[i], o], [q[i], o]];
        guides[i] = [q[i] < way[0][0] ? [q[i], o] : way[0], q[i] > way[1][0] ? [q[i], o] : way[1]];
      });
      model.contacts.forEach((c, i) => c.spots.forEach((pair, k) => {
        const s = geometry.spot(pair), t = tangentOf(geometry, pair), r = travel[i][k];
        travel[i][k] = [Math.min(r[0], t), Math.max(r[1], t)];
        if (!c.load) include(contacts, s.a.at, s.a.radius || 0);
        if (!c.load && !s.b.n) include(contacts, s.b.at, s.b.radius);
        if (i === model.string) include(contacts, [s.a.at[0], s.b.at[1]]);
      }));
    };
    engine.reset();
    look();
    for (let n = 0; n < looks; n++) {
      engine.advance(Math.max(1, Math.round(steps / looks)));
      look();
    }
    const { view, spatial } = directions(spreads(runs), geometry.views);
    const boxes = {}, starts = {};
    for (const name of geometry.views) {
      geometry.look(name);
      boxes[name] = [...contacts];
      starts[name] = emptyBox();
      runs.forEach((r) => r.forEach((p) => include(boxes[name], geometry.project(p))));
      runs[0].forEach((p) => include(starts[name], geometry.project(p)));
      widen(boxes[name]);
      widen(starts[name]);
    }
    geometry.look(view);
    const room = (scene.action ? 0.02 : 0.25) * sizeOf(boxes[view]);
    travel.forEach((c) => c.forEach((r) => { r[0] -= room; r[1] += room; }));
    const roams = model.contacts.length === 0 && sizeOf(boxes[view]) > roaming * sizeOf(starts[view]);
    scene.learn({ boxes: roams ? starts : boxes, roams, view, travel, guides: guides.filter((k) => k).map((k) => k.map(([, o]) => o)) });
    return { view, spatial };
  }

  return { run, include, emptyBox, widen };
})();
