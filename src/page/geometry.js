/* SPDX-License-Identifier: MIT
 * geometry.js - where everything is: the mechanism's own numbers at the parameters of the moment,
 * turned along its tree. Three-dimensional; what is drawn is its projection. */
"use strict";

const Geometry = (() => {
  const apply = { "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b,
                  "/": (a, b) => a / b };
  const unary = { neg: (a) => -a, sin: Math.sin, cos: Math.cos, tan: Math.tan, sqrt: Math.sqrt };
  const index = { x: 0, y: 1, z: 2 };

  /* a number of the geometry: itself, or a formula in postfix order */
  function value(s, params) {
    if (typeof s === "number") return s;
    const stack = [];
    for (const step of s) {
      if (typeof step === "number") stack.push(step);
      else if (step in apply) { const b = stack.pop(); stack.push(apply[step](stack.pop(), b)); }
      else if (step in unary) stack.push(unary[step](stack.pop()));
      else stack.push(params[+step.slice(1)]);
    }
    return stack[0];
  }

  const product = (A, B) => A.map((row) => [0, 1, 2].map(
    (j) => row[0] * B[0][j] + row[1] * B[1][j] + row[2] * B[2][j]));
  const times = (A, v) => A.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);

  function rotation(axis, angle) {
    const c = Math.cos(angle), s = Math.sin(angle);
    const [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
    const R = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    R[i][i] = R[j][j] = c;
    R[i][j] = -s;
    R[j][i] = s;
    return R;
  }

  /* Directions to look from: what is right and up in the drawing. Contacts and notches lie in the
   * plane x-z, so a mechanism that has any is seen from the front only. */
  const c = Math.cos(Math.PI / 6), s = Math.sin(Math.PI / 6), k = Math.sin(Math.PI / 9);
  const views = {
    front: { right: [1, 0, 0], up: [0, 0, 1] },
    side: { right: [0, 1, 0], up: [0, 0, 1] },
    top: { right: [1, 0, 0], up: [0, 1, 0] },
    oblique: { right: [c, s, 0], up: [-s * k, c * k, Math.cos(Math.PI / 9)] },
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

  function create(model) {
    const flatOnly = model.contacts.length + model.notches.length > 0;
    let view = views.front;
    const params = Float64Array.from(model.values);
    const fixed = { R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], o: [0, 0, 0] };
    const frames = model.bodies.map(() => fixed);
    const num = (s) => value(s, params);
    const vec = (v) => v.map(num);
    const frame = (body) => (body < 0 ? fixed : frames[body]);

    function place(q) {
      model.bodies.forEach((b, i) => {
        const p = frame(b.parent), at = times(p.R, vec(b.at)), axis = index[b.axis];
        const o = [0, 1, 2].map((k) => p.o[k] + at[k]);
        let R = p.R;
        if (b.type === "R") R = product(R, rotation(axis, b.sign * q[i]));
        else for (let k = 0; k < 3; k++) o[k] += p.R[k][axis] * b.sign * q[i];
        frames[i] = { R, o };
      });
    }

    const project = (w) => [dot(w, view.right), dot(w, view.up)];
    /* a place given in a body's axes: in the fixed ones, and in the drawing */
    function world(body, v) {
      const f = frame(body), w = times(f.R, v);
      return [f.o[0] + w[0], f.o[1] + w[1], f.o[2] + w[2]];
    }
    const at = (body, v) => project(world(body, v));
    const local = (body, x, z) => at(body, [x, 0, z]);
    const direction = (body, angle) =>
      project(times(frame(body).R, [Math.cos(angle), 0, Math.sin(angle)]));

    /* every place that is known of bodies, joints and points, in the fixed axes */
    function places() {
      const list = [];
      model.bodies.forEach((b, i) => {
        if (!b.load) list.push(world(i, [0, 0, 0]), world(i, vec(b.centre)));
      });
      model.points.forEach((p) => list.push(world(p.body, vec(p.at))));
      model.notches.forEach((k) => list.push(world(k.catcher, vec(k.corner))));
      return list;
    }

    /* one side of a contact now: at, and radius or normal n and extent along the tangent */
    function shape(s) {
      if (s.facing === undefined) return { at: at(s.body, vec(s.at)), radius: num(s.radius) };
      const n = direction(s.body, num(s.facing)), t = [n[1], -n[0]];
      const extent = s.extent ? s.extent.map(num) : null;
      const here = at(s.body, vec(s.at));
      if (!s.end) return { at: here, n, t, extent };
      const along = extent[s.end > 0 ? 1 : 0];
      return { at: [here[0] + along * t[0], here[1] + along * t[1]], radius: 0 };
    }

    /* two sides that may touch: normal on the first, gap, the place between them */
    function spot(pair) {
      const a = shape(pair[0]), b = shape(pair[1]);
      const r = [a.at[0] - b.at[0], a.at[1] - b.at[1]];
      const far = Math.hypot(r[0], r[1]);
      const n = b.n || (far > 0 ? [r[0] / far, r[1] / far] : [0, 1]);
      const gap = r[0] * n[0] + r[1] * n[1] - a.radius - (b.n ? 0 : b.radius);
      return { a, b, n, gap, at: [a.at[0] - a.radius * n[0], a.at[1] - a.radius * n[1]] };
    }

    /* corner and unit vectors of roof and vertical face, end and upper face of the beak */
    function notch(k) {
      const lean = num(k.lean), tilt = num(k.tilt);
      return { corner: at(k.catcher, vec(k.corner)), end: at(k.beak, vec(k.end)),
               face: direction(k.catcher, lean + Math.PI / 2),
               roof: direction(k.catcher, lean + Math.PI / 2 + num(k.angle)),
               beak: direction(k.beak, tilt) };
    }

    return { model, params, num, vec, place, places, world, at, project, local, shape, spot, notch,
             views: flatOnly ? ["front"] : Object.keys(views), look(name) { view = views[name]; },
             flat: (v) => { const w = vec(v); return [w[0], w[2]]; },
             /* the present axis of a body's joint, in the drawing */
             along: (body, axis) => project(frame(body).R.map((row) => row[axis])) };
  }

  return { create };
})();
