/* SPDX-License-Identifier: MIT
 * scene.js - the mechanism drawn to scale. Any mechanism is drawn from its points, joints and
 * surfaces; a key, hammer and pawl with a notch between them get their own shapes, which pass
 * through the same points. */
"use strict";

const Scene = (() => {
  const mm = 1e-3;
  const { makeView, convexHull } = Brush;

  /* which bodies are key, hammer and pawl; null without such an action */
  function findAction(model) {
    const k = model.notches[model.notch];
    if (!k || k.beak < 0 || k.catcher < 0 || model.bodies[k.beak].parent < 0) return null;
    return { hammer: k.beak, pawl: k.catcher, key: model.bodies[k.beak].parent, notch: k };
  }

  function create(canvas, geometry) {
    const ctx = canvas.getContext("2d"), g = geometry, model = g.model;
    const { path, smooth, paint, disc, arrow } = Brush.create(ctx);
    const action = findAction(model), shaped = action ? [action.key, action.hammer, action.pawl] : [];
    const others = model.bodies.map((_, i) => i).filter((i) => !model.bodies[i].load && !shaped.includes(i));
    const margin = action ? 0.05 : 0.08; // around the box, of its size
    let boxes = {}, box = [-0.1, -0.1, 0.1, 0.1], roams = false, size = 0.2, travel = [], guides = [];
    let view = null, lens = null, width = 0, height = 0, extra = 0, colour = {}, alpha = 1;

    const shapeOn = (body, points, v, fill, r = 0.8 * mm) => {
      smooth(points.map((p) => g.local(body, p[0], p[1])), v, r);
      paint(fill, colour.edge);
    };
    function pin(at, v) {
      disc(at, Math.max(1.6 * mm * size / 0.33, 2 / v.s), v, colour.brass, colour.edge);
    }

    /* ---- surfaces ---- */

    /* felt on wood behind the line of a contact, as long as what touches it travels */
    function pad(pair, reach, v, isString) {
      const b = g.shape(pair[1]);
      if (!b.n) return;
      const on = (along, deep) => [b.at[0] + along * b.t[0] - deep * b.n[0],
                                   b.at[1] + along * b.t[1] - deep * b.n[1]];
      const [from, to] = b.extent || reach, th = 0.011 * size;
      if (isString) {
        ctx.save();
        ctx.lineCap = "round";
        for (const [deep, w] of [[0, 1.6], [0.9 * mm, 1.6]]) {
          path([on(from, deep), on(to, deep)], v, false);
          paint(null, colour.string, w);
        }
        ctx.restore();
        return;
      }
      if (pair[1].body < 0) {
        path([on(from, th), on(to, th), on(to, 2.6 * th), on(from, 2.6 * th)], v);
        paint(colour.frame, null);
      }
      path([on(from, 0), on(to, 0), on(to, th), on(from, th)], v);
      paint(colour.felt, null);
    }

    function pads(v, onFrame) {
      model.contacts.forEach((c, i) => c.spots.forEach((pair, k) => {
        if (!c.load && pair[1].body < 0 === onFrame && travel[i])
          pad(pair, travel[i][k], v, i === model.string);
      }));
    }

    /* ---- any body ---- */

    /* what is known of a body's outline, in its own axes */
    function marks(body) {
      const p = [[0, 0, 0]], round = [];
      const add = (v) => p.push(g.vec(v));
      model.points.forEach((k) => { if (k.body === body) add(k.at); });
      model.bodies.forEach((b) => { if (b.parent === body && !b.load) add(b.at); });
      model.notches.forEach((k) => {
        if (k.catcher === body) add(k.corner);
        if (k.beak === body) add(k.end);
      });
      model.contacts.forEach((c) => c.spots.forEach((pair) => pair.forEach((s) => {
        if (s.body !== body || c.load) return;
        if (s.facing === undefined && g.num(s.radius) > 0)
          round.push([g.vec(s.at), g.num(s.radius)]);
        else if (s.extent) {
          const f = g.num(s.facing), at = g.vec(s.at);
          for (const e of s.extent)
            p.push([at[0] + g.num(e) * Math.sin(f), at[1], at[2] - g.num(e) * Math.cos(f)]);
        } else add(s.at);
      })));
      // a body of which only the joint and the mass are known
      if (p.length === 1 && round.length === 0) add(model.bodies[body].centre);
      return { points: p, round };
    }

    /* a body of which one place is known: a block that slides, a wheel that turns */
    function blockOrWheel(body, v, tone) {
      const b = model.bodies[body], at = g.local(body, 0, 0), r = 0.035 * size;
      const axis = { x: 0, y: 1, z: 2 }[b.axis];
      if (b.type === "R") {
        disc(at, r, v, tone, colour.edge);
        const spoke = g.along(body, (axis + 1) % 3);
        path([at, [at[0] + r * spoke[0], at[1] + r * spoke[1]]], v, false);
        paint(null, colour.edge, 1.5);
        return;
      }
      const d = g.along(body, axis), long = Math.hypot(...d);
      const [u, w] = long > 0.1 ? [d[0] / long, d[1] / long] : [1, 0];
      const corner = (a, c) => [at[0] + r * (a * u - c * w), at[1] + r * (a * w + c * u)];
      path([corner(1, 0.7), corner(1, -0.7), corner(-1, -0.7), corner(-1, 0.7)], v);
      paint(tone, colour.edge);
    }

    function anyBody(body, v) {
      const { points, round } = marks(body), r = 0.013 * size;
      const tone = [colour.wood, colour.wood2, colour.wood3][body % 3];
      if (points.some((p) => Math.hypot(...p) > 0.5 * r)) {
        const hull = convexHull(points.map((p) => g.at(body, p)));
        ctx.lineJoin = ctx.lineCap = "round";
        path(hull.length > 1 ? hull : [hull[0], [hull[0][0] + 0.01 * r, hull[0][1]]], v);
        paint(null, colour.edge, 2 * r * v.s + 2);
        paint(tone, tone, 2 * r * v.s);
      } else if (round.length === 0) blockOrWheel(body, v, tone);
      for (const [c, radius] of round) disc(g.at(body, c), radius, v, tone, colour.edge);
    }

    /* how much of the drawing a body covers [m^2] */
    function area(body) {
      const h = convexHull(marks(body).points.map((p) => g.at(body, p)));
      return Math.abs(h.reduce((sum, p, i) => {
        const q = h[(i + 1) % h.length];
        return sum + p[0] * q[1] - q[0] * p[1];
      }, 0));
    }

    /* bodies that have no shape of their own: large ones behind small ones, pins in front of all */
    function anyBodies(list, v) {
      const sorted = list.map((i) => [i, area(i)]).sort((a, b) => b[1] - a[1] || a[0] - b[0]);
      for (const [i] of sorted) anyBody(i, v);
      for (const i of list) if (model.bodies[i].type === "R") pin(g.local(i, 0, 0), v);
    }

    /* ---- loops ---- */

    const place = (point) => {
      const p = model.points[point];
      return g.at(p.body, g.vec(p.at));
    };

    /* rods and slots, behind the bodies that they close a loop with */
    function loops(v) {
      ctx.lineCap = "round";
      for (const l of model.loops) {
        const [a, b] = [place(l.from), place(l.to)];
        if (l.kind === "rod") {
          path([a, b], v, false);
          paint(null, colour.edge, 0.02 * size * v.s + 2);
          paint(null, colour.frame, 0.02 * size * v.s);
        } else if (l.kind === "slot") {
          const d = g.along(model.points[l.from].body, l.axis), far = 0.12 * size;
          path([-1, 1].map((k) => [a[0] + k * far * d[0], a[1] + k * far * d[1]]), v, false);
          paint(null, colour.frame, 0.03 * size * v.s);
        }
      }
    }
    function loopPins(v) {
      for (const l of model.loops) {
        if (l.kind !== "slot") pin(place(l.from), v);
        pin(place(l.to), v);
      }
    }

    /* ---- key, hammer, pawl ---- */

    function key(v) {
      const own = model.points.filter((p) => p.body === action.key).map((p) => g.flat(p.at));
      const fork = g.flat(model.bodies[action.hammer].at);
      const rest = own.filter((p) => Math.hypot(p[0] - fork[0], p[1] - fork[1]) > 1e-6);
      const u = rest.map((p) => p[0]), w = rest.map((p) => p[1]);
      const [left, right] = [Math.min(...u) - 4 * mm, Math.max(...u) + 6 * mm];
      const [low, top] = [Math.min(...w), Math.max(...w)];
      // the Kapsel: a brass fork on the key
      const stem = 3.2 * mm;
      shapeOn(action.key, [[fork[0] - stem, top - 1 * mm], [fork[0] + stem, top - 1 * mm],
                           [fork[0] + 0.8 * stem, fork[1] + 3 * mm],
                           [fork[0] - 0.8 * stem, fork[1] + 3 * mm]], v, colour.brass);
      // posts under surfaces of the key that stand above its bar
      model.contacts.forEach((c) => c.spots.forEach((pair) => {
        const s = pair[1];
        if (s.body !== action.key || s.facing === undefined) return;
        const at = g.flat(s.at);
        if (at[1] > top) shapeOn(action.key, [[at[0] - 3 * mm, top - 1 * mm],
          [at[0] + 3 * mm, top - 1 * mm], [at[0] + 3 * mm, at[1] - 2 * mm],
          [at[0] - 3 * mm, at[1] - 2 * mm]], v, colour.wood3);
      }));
      const slim = low + 0.3 * (top - low);
      shapeOn(action.key, [[left, low], [left + 12 * mm, low], [left + 30 * mm, slim],
                           [right - 75 * mm, slim], [right - 60 * mm, low], [right, low],
                           [right, top], [left, top]], v, colour.wood, 2 * mm);
      shapeOn(action.key, [[right - 62 * mm, top - 2.4 * mm], [right + 1.5 * mm, top - 2.4 * mm],
                           [right + 1.5 * mm, top], [right - 62 * mm, top]], v, colour.plate);
      ctx.globalAlpha = 0.35 * alpha;
      for (const f of [0.42, 0.58, 0.74]) { // the grain
        path([g.local(action.key, left + 20 * mm, low + f * (top - low)),
              g.local(action.key, right - 66 * mm, low + (f + 0.04) * (top - low))], v, false);
        paint(null, colour.edge, 0.6);
      }
      ctx.globalAlpha = alpha;
      pin(g.local(action.key, 0, 0), v);
    }

    function hammer(v) {
      const k = action.notch, end = g.flat(k.end), tilt = g.num(k.tilt);
      const face = (s, deep) => [end[0] + s * Math.cos(tilt) + deep * Math.sin(tilt),
                                 end[1] + s * Math.sin(tilt) - deep * Math.cos(tilt)];
      const own = model.points.filter((p) => p.body === action.hammer).map((p) => g.flat(p.at));
      const head = own.reduce((a, b) => (b[0] > a[0] ? b : a), [0.05, 0.01]);
      const long = Math.hypot(...end);
      const under = Math.min(...own.map((p) => p[1]), -1.5 * mm);
      // shank, head with its leather, beak with its leather
      shapeOn(action.hammer, [face(0, 1.1 * mm), face(0.9 * long, 1.1 * mm), [0, 2.4 * mm],
                              [head[0], 1.6 * mm], [head[0], -1.6 * mm],
                              [0.4 * head[0], under], [0.05 * head[0], under],
                              face(0.5 * long, 3.4 * mm), face(0, 3 * mm)], v, colour.wood2, 1 * mm);
      shapeOn(action.hammer, [[head[0] - 5 * mm, -3 * mm], [head[0] + 5 * mm, -3 * mm],
                              [head[0] + 4 * mm, head[1] - 3 * mm],
                              [head[0] - 4 * mm, head[1] - 3 * mm]], v, colour.wood2, 1.5 * mm);
      shapeOn(action.hammer, [[head[0] + 4.2 * mm, head[1] - 3.6 * mm],
                              [head[0] + 3 * mm, head[1] - 0.6 * mm], [head[0], head[1]],
                              [head[0] - 3 * mm, head[1] - 0.6 * mm],
                              [head[0] - 4.2 * mm, head[1] - 3.6 * mm]], v, colour.leather, 1 * mm);
      shapeOn(action.hammer, [face(0, 0), face(0.75 * long, 0), face(0.75 * long, 1.3 * mm),
                              face(0, 1.3 * mm)], v, colour.leather, 0.15 * mm);
      pin(g.local(action.hammer, 0, 0), v);
    }

    function pawl(v) {
      const k = action.notch, c = g.flat(k.corner);
      const lean = g.num(k.lean) + Math.PI / 2, angle = g.num(k.angle);
      const f = [Math.cos(lean), Math.sin(lean)];
      const r = [Math.cos(lean + angle), Math.sin(lean + angle)];
      const on = (a, b) => [c[0] + a * r[0] + b * f[0], c[1] + a * r[1] + b * f[1]];
      const own = model.points.filter((p) => p.body === action.pawl).map((p) => g.flat(p.at))
        .filter((p) => Math.hypot(p[0] - c[0], p[1] - c[1]) > 1e-6);
      const back = own[0] || [0, 0.9 * c[1]];
      const inner = on(4.6 * mm, 0), w = 4.2 * mm;
      shapeOn(action.pawl, [[w, -w], [w, 0.3 * c[1]], [back[0], 0.75 * back[1]],
                            [back[0], back[1] + 0.4 * mm], [inner[0] + 1.2 * mm, back[1] + 0.4 * mm],
                            [inner[0], inner[1] - 1.6 * mm], inner, c, on(0, 10 * mm),
                            on(4 * mm, 13.5 * mm), on(11.5 * mm, 9 * mm),
                            [c[0] - 11 * mm, 0.8 * c[1]], [c[0] - 4 * mm, 0.35 * c[1]],
                            [-w, -w]], v, colour.wood3, 0.25 * mm);
      pin(g.local(action.pawl, 0, 0), v);
    }

    /* ---- the load, its forces ---- */

    /* a cube of brass: its mass, edge and foot; beside the action it hangs above its place */
    function weight(present) {
      const c = model.contacts.find((k) => k.load);
      if (!c) return null;
      const { a, b } = g.spot(c.spots[0]), mass = g.num(model.bodies.find((k) => k.load).mass);
      return { mass, side: Math.cbrt(mass / 8500),
               at: present ? [a.at[0], b.at[1]] : [a.at[0], a.at[1] + 0.085 * size] };
    }

    function load(v, present) {
      const w = weight(present);
      if (!w) return;
      const { mass, side, at } = w;
      const block = [[-0.5, 0], [0.5, 0], [0.42, 0.92], [0.12, 0.92], [0.16, 1.2], [-0.16, 1.2],
                     [-0.12, 0.92], [-0.42, 0.92]].map(
        (p) => [at[0] + p[0] * side, at[1] + p[1] * side]);
      ctx.save();
      if (!present) { ctx.setLineDash([3, 3]); ctx.globalAlpha = 0.55; }
      smooth(block, v, 0.06 * side);
      paint(present ? colour.brass : null, present ? colour.edge : colour.muted);
      ctx.restore();
      const [x, y] = v.to([at[0], at[1] + 0.46 * side]);
      if (side * v.s > 34) text(Math.round(1e3 * mass) + " g", x, y + 3.5, "center",
           present ? colour.onbrass : colour.muted, 10.5);
    }


    /* forces as arrows that grow with the root of the force: felt and blow both show */
    function forces(v, now) {
      const values = now.forces;
      const length = (f) => Math.min(70, 13 * Math.sqrt(f)) / v.s;
      const from = (at, n, f) => arrow([at[0] - length(f) * n[0], at[1] - length(f) * n[1]], at, v,
                                       colour.force, 2);
      model.contacts.forEach((c, i) => {
        if (values[2 * i] > 0.02 && !(c.load && !now.loadPresent)) {
          const s = g.spot(c.spots[0]);
          from(s.at, s.n, values[2 * i]);
        }
      });
      model.notches.forEach((k, i) => {
        const f = values[2 * (model.contacts.length + i)], n = g.notch(k);
        const face = now.phase === 4 && i === model.notch;
        if (f > 0.02) from(n.end, face ? [n.face[1], -n.face[0]] : [n.beak[1], -n.beak[0]], f);
      });
    }

    function fingers(v, pushes) {
      model.inputs.forEach((input, i) => {
        if (input.kind !== "point" || !(Math.abs(pushes[i]) > 1e-3)) return;
        const p = model.points[input.index], at = g.at(p.body, g.vec(p.at));
        const d = g.project(g.vec(input.direction)), n = Math.hypot(...d) || 1;
        const long = (18 + 16 * Math.sqrt(Math.abs(pushes[i]))) / v.s;
        arrow([at[0] - long * d[0] / n, at[1] - long * d[1] / n], at, v, colour.finger, 5);
      });
    }

    /* ---- words ---- */

    function text(words, x, y, align, tone, px) {
      ctx.font = `${px}px ${colour.font}`;
      ctx.textAlign = align;
      ctx.fillStyle = tone;
      ctx.fillText(words, x, y);
    }

    function label(words, at, dx, dy, align = "center") {
      const [x, y] = view.to(at);
      ctx.globalAlpha = 0.7;
      ctx.beginPath();
      ctx.moveTo(x, y);
      ctx.lineTo(x + dx, y + dy + (dy < 0 ? 4 : -11));
      paint(null, colour.muted, 0.7);
      ctx.globalAlpha = 1;
      ctx.font = `12.5px ${colour.font}`; // paper around the letters, whatever is under them
      ctx.textAlign = align;
      ctx.lineJoin = "round";
      ctx.strokeStyle = colour.paper;
      ctx.lineWidth = 4;
      ctx.strokeText(words, x + dx, y + dy);
      text(words, x + dx, y + dy, align, colour.muted, 12.5);
    }

    /* names of bodies beside the middle of their outlines, where there are not too many of them */
    function bodyNames() {
      if (others.length > 8) return;
      const taken = [];
      for (const i of others) {
        const marked = marks(i).points.concat(marks(i).round.map(([c]) => c)).map((p) => g.at(i, p));
        const [u, w] = [0, 1].map((k) => marked.reduce((sum, p) => sum + p[k], 0) / marked.length);
        const words = Words.of(model.bodies[i].name.replace(/_/g, " "));
        const [x, y] = view.to([u, w]), half = 3.6 * words.length;
        const free = [-26, 34, -46, 54].find((dy) => y + dy > 14 && y + dy < height - 4 &&
          !taken.some((q) => Math.abs(q[0] - x) < half + q[2] && Math.abs(q[1] - y - dy) < 16)) ?? -26;
        taken.push([x, y + free, half]);
        label(words, [u, w], Math.min(Math.max(x, half + 2), width - half - 2) - x, free);
      }
    }

    function labels() {
      if (!action) {
        bodyNames();
        return;
      }
      const local = (b, p) => g.local(b, p[0], p[1]);
      const k = g.notch(action.notch);
      if (width < 640) { // a telephone has room for three
        label(Words.t("hammer"), local(action.hammer, [0.05, 0.001]), -6, -30);
        label(Words.t("pawl"), k.corner, -12, -27);
        label(Words.t("key"), local(action.key, [0.06, 0.004]), 0, 34);
        return;
      }
      const point = (name) => {
        const p = model.points.find((q) => q.name === name);
        return p ? g.at(p.body, g.vec(p.at)) : null;
      };
      const head = point(model.bodies[action.hammer].name + ".head");
      const front = point(model.bodies[action.key].name + ".front");
      label(Words.t("pawl"), local(action.pawl, [-0.003, 0.012]), -44, 14);
      label(Words.t("stop"), g.spot(model.contacts.find((c) => c.spots[0][0].body === action.pawl)?.spots[0] ||
                           model.contacts[0].spots[0]).at, 44, 84);
      label(Words.t("notch"), k.corner, -46, -34);
      label("Kapsel", local(action.hammer, [0, 0.002]), 22, -46);
      label(Words.t("hammer"), local(action.hammer, [0.06, 0.001]), 4, -34);
      if (head) label(Words.t("string"), [head[0] + 0.055, g.num(0) + stringHeight()], 0, -12);
      label(Words.t("key"), local(action.key, [0.025, 0.004]), 6, -34);
      label(Words.t("balancePin"), local(action.key, [0, 0]), 0, 44);
      if (front) label(Words.t("fingerPlace"), [front[0] - 0.02, front[1]], 10, -24);
    }

    function stringHeight() {
      return model.string < 0 ? 0 : g.shape(model.contacts[model.string].spots[0][1]).at[1];
    }

    /* ---- all of it ---- */

    function bodies(v, present) {
      if (action) {
        key(v);
        load(v, present);
        pawl(v);
        hammer(v);
        anyBodies(others, v);
      } else {
        anyBodies(others, v);
        load(v, present);
      }
    }

    function drawGuides(v) {
      ctx.save();
      ctx.setLineDash([2, 5]);
      for (const line of guides) {
        path(line.map(g.project), v, false);
        paint(null, colour.muted, 1);
      }
      ctx.restore();
    }

    function links(v) {
      for (const k of model.links) {
        const ends = [place(k.from), place(k.to)];
        const n = 12, [a, b] = ends, d = [b[0] - a[0], b[1] - a[1]];
        const side = 0.012 * size / (Math.hypot(...d) || 1), zigzag = [];
        for (let i = 0; i <= n; i++) {
          const w = i === 0 || i === n ? 0 : i % 2 ? side : -side, f = i / n;
          zigzag.push([a[0] + f * d[0] - w * d[1], a[1] + f * d[1] + w * d[0]]);
        }
        path(zigzag, v, false);
        paint(null, colour.string, 1.5);
      }
    }

    function balance(v) { // the frame under the joints that stand on it
      model.bodies.forEach((b) => {
        if (b.parent >= 0 || b.type !== "R") return;
        const o = g.at(-1, g.vec(b.at)), w = 0.02 * size;
        path([[o[0], o[1]], [o[0] + 0.6 * w, o[1] - 1.4 * w], [o[0] - 0.6 * w, o[1] - 1.4 * w]], v);
        paint(colour.frame, null);
        path([[o[0] - w, o[1] - 1.4 * w], [o[0] + w, o[1] - 1.4 * w]], v, false);
        paint(null, colour.frame, 3);
      });
    }

    function everything(v, now) {
      balance(v);
      drawGuides(v);
      pads(v, true);
      links(v);
      loops(v);
      bodies(v, now.loadPresent);
      loopPins(v);
      pads(v, false);
      forces(v, now);
    }

    /* the notch under a lens */
    function drawLens(now) {
      if (!lens) return;
      const k = g.notch(action.notch);
      const v = makeView(lens.s, lens.x, lens.y, k.corner[0] + 1 * mm, k.corner[1] - 0.4 * mm);
      ctx.save();
      ctx.beginPath();
      ctx.arc(lens.x, lens.y, lens.r, 0, 2 * Math.PI);
      ctx.fillStyle = colour.paper;
      ctx.fill();
      ctx.clip();
      everything(v, now);
      ctx.restore();
      ctx.beginPath();
      ctx.arc(lens.x, lens.y, lens.r, 0, 2 * Math.PI);
      paint(null, colour.brass, 3);
      const [x, y] = view.to(k.corner), far = Math.hypot(x - lens.x, y - lens.y);
      disc(k.corner, lens.r / lens.s, view, null, colour.brass);
      const r0 = lens.r / lens.s * view.s;
      ctx.beginPath();
      ctx.moveTo(x + (lens.x - x) * r0 / far, y + (lens.y - y) * r0 / far);
      ctx.lineTo(lens.x + (x - lens.x) * lens.r / far, lens.y + (y - lens.y) * lens.r / far);
      ctx.globalAlpha = 0.6;
      paint(null, colour.brass, 1);
      ctx.globalAlpha = 1;
      const magnified = Math.round(lens.s / view.s);
      text(Words.t("lens", magnified), lens.x, lens.y + lens.r + 15, "center",
           colour.muted, 11.5);
    }

    /* a length of 1, 2 or 5 times a power of ten, about an eighth of the width */
    function scaleBar() {
      const wish = 0.13 * width / view.s, ten = 10 ** Math.floor(Math.log10(wish));
      const long = ten * [5, 2, 1].find((m) => m * ten <= wish);
      const [x1, x0, y] = [width - 4, width - 4 - long * view.s, height - 6];
      ctx.beginPath();
      for (const x of [x0, x1]) { ctx.moveTo(x, y - 4); ctx.lineTo(x, y); }
      ctx.moveTo(x0, y);
      ctx.lineTo(x1, y);
      paint(null, colour.muted, 1);
      const words = long < 1 ? `${+(1e3 * long).toPrecision(3)} mm` : `${long} m`;
      const roomy = x1 - x0 > 50;
      text(words, roomy ? (x0 + x1) / 2 : x1, y - 7, roomy ? "center" : "right", colour.muted, 11.5);
    }

    function draw(now) {
      const ratio = canvas.width / width;
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      ctx.clearRect(0, 0, width, height);
      if (roams) follow();
      for (const ghost of now.ghosts) drawGhost(ghost, now.q);
      everything(view, now);
      fingers(view, now.pushes);
      scaleBar();
      if (now.named) labels();
      drawLens(now);
    }

    /* a frozen stroke: silhouettes of the bodies, with the parameters they had */
    function drawGhost(ghost, q) {
      const [own, params] = [colour, g.params.slice()];
      colour = Object.fromEntries(Object.keys(own).map((k) => [k, k === "edge" ? own.muted : own.rule]));
      g.params.set(ghost.params);
      g.place(ghost.q);
      bodies(view, ghost.load);
      g.params.set(params);
      g.place(q);
      colour = own;
    }

    /* room on the page, and what has to be seen: box [left, bottom, right, top] in metres */
    function fit(cssWidth, most, ratio) {
      const w = box[2] - box[0], h = box[3] - box[1];
      width = cssWidth;
      const roomy = width >= 540, small = Math.min(0.18 * width, 72);
      extra = action && !roomy ? 2.35 * small : 0; // the lens above the string
      height = Math.round(Math.min(most, Math.max(0.3 * width, width * (h / w) * (1 + margin) + 40)
                                   + extra));
      frame();
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      canvas.style.height = height + "px";
      lens = null;
      if (action) {
        const r = roomy ? Math.min(0.225 * height, 0.12 * width) : small;
        lens = { r, s: r / (6.5 * mm), x: roomy ? view.x(box[2]) - 2.8 * r : width - r - 12,
                 y: roomy ? r + 10 : r + 8 };
      }
      if (model.string >= 0) travel[model.string] = travel[model.string].map(
        () => [-4 * w, 4 * w]);
    }
    function frame() {
      const w = box[2] - box[0], h = box[3] - box[1];
      const s = Math.min(width / (w * (1 + 2 * margin)), (height - extra) / (h * (1 + 2 * margin)));
      view = makeView(s, width / 2, extra + (height - extra) / 2, (box[0] + box[2]) / 2,
                      (box[1] + box[3]) / 2);
    }
    /* a mechanism that leaves its place: the box grows with it at once and shrinks slowly */
    function follow() {
      const now = Preview.emptyBox();
      for (const p of g.places()) Preview.include(now, g.project(p));
      Preview.widen(now);
      box = box.map((b, i) => (i < 2 ? Math.min(now[i], b + 0.03 * (now[i] - b))
                                     : Math.max(now[i], b + 0.03 * (now[i] - b))));
      frame();
    }

    return {
      draw, fit, action,
      /* what a run of the mechanism has shown */
      learn(seen) {
        [boxes, roams, travel, guides] = [seen.boxes, seen.roams, seen.travel, seen.guides];
        this.look(seen.view);
      },
      /* from another direction; fit follows */
      look(name) {
        g.look(name);
        box = [...boxes[name]];
        size = Math.max(box[2] - box[0], box[3] - box[1]);
      },
      theme(tones) { colour = tones; },
      /* a place of the drawing [m] on the canvas */
      to: (p) => view.to(p),
      /* middle of the load on the canvas, or of where it waits, half its width and height */
      weightAt(present) {
        const w = weight(present);
        if (!w) return null;
        const half = 0.5 * w.side * view.s, at = view.to([w.at[0], w.at[1] + 0.6 * w.side]);
        return [...at, Math.max(half, 14), Math.max(1.2 * half, 14)];
      },
      /* does a place on the canvas lie near the point of an input? its index, -1: none is near */
      inputAt(x, y) {
        let best = -1, near = 90;
        model.inputs.forEach((input, i) => {
          if (input.kind !== "point") return;
          const p = model.points[input.index], [px, py] = view.to(g.at(p.body, g.vec(p.at)));
          const far = Math.hypot(x - px, y - py);
          if (far < near) [best, near] = [i, far];
        });
        return best;
      },
    };
  }

  return { create };
})();
