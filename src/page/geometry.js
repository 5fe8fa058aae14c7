/* SPDX-License-Identifier: MIT
 * geometry.js - where everything is: the mechanism's own numbers at the parameters of the moment,
 * turned along its tree. Three-dimensional; what is drawn is one plane of it. */
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

  /* the plane that most of the mechanism moves in: [right, up] */
  function planeOf(model) {
    if (model.contacts.length > 0) return [0, 2];
    const about = (axis) => model.bodies.some((b) => b.type === "R" && b.axis === axis);
    if (about("y")) return [0, 2];
    if (about("x")) return [1, 2];
    return about("z") ? [0, 1] : [0, 2];
  }

  function create(model) {
    const plane = planeOf(model), [U, V] = plane;
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

    /* a place given in a body's axes, in the plane */
    function at(body, v) {
      const f = frame(body), w = times(f.R, v);
      return [f.o[U] + w[U], f.o[V] + w[V]];
    }
    /* the same of a place given in the plane */
    function local(body, u, v) {
      const p = [0, 0, 0];
      p[U] = u;
      p[V] = v;
      return at(body, p);
    }
    function direction(body, angle) {
      const f = frame(body), v = [0, 0, 0];
      v[U] = Math.cos(angle);
      v[V] = Math.sin(angle);
      const w = times(f.R, v);
      return [w[U], w[V]];
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

    return { model, params, plane, num, vec, place, at, local, shape, spot, notch,
             flat: (v) => { const w = vec(v); return [w[U], w[V]]; } };
  }

  return { create };
})();
