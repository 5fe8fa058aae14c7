/* SPDX-License-Identifier: MIT
 * brush.js - paths, discs and arrows on a canvas, from places in metres. A view says where they lie. */
"use strict";

const Brush = (() => {
  /* metres to pixels: s pixels a metre, (u, v) lies at (x, y) */
  const makeView = (s, x, y, u, v) => ({
    s, x: (a) => x + s * (a - u), y: (b) => y - s * (b - v),
    to: (p) => [x + s * (p[0] - u), y - s * (p[1] - v)],
  });

  function convexHull(points) {
    const p = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = (list) => {
      const h = [];
      for (const c of list) {
        while (h.length > 1) {
          const [a, b] = [h[h.length - 2], h[h.length - 1]];
          if ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0) break;
          h.pop();
        }
        h.push(c);
      }
      return h.slice(0, -1);
    };
    return p.length < 3 ? p : [...half(p), ...half(p.reverse())];
  }

  function create(ctx) {
    function path(points, v, close = true) {
      ctx.beginPath();
      points.forEach((p, i) => {
        const [x, y] = v.to(p);
        if (i === 0) ctx.moveTo(x, y);
        else ctx.lineTo(x, y);
      });
      if (close) ctx.closePath();
    }
    /* the same with corners rounded by r [m] */
    function smooth(points, v, r) {
      const n = points.length, p = points.map(v.to);
      ctx.beginPath();
      ctx.moveTo((p[0][0] + p[n - 1][0]) / 2, (p[0][1] + p[n - 1][1]) / 2);
      for (let i = 0; i < n; i++) {
        const next = p[(i + 1) % n];
        ctx.arcTo(p[i][0], p[i][1], (p[i][0] + next[0]) / 2, (p[i][1] + next[1]) / 2, r * v.s);
      }
      ctx.closePath();
    }
    function paint(fill, edge, w = 1) {
      if (fill) { ctx.fillStyle = fill; ctx.fill(); }
      if (edge) { ctx.strokeStyle = edge; ctx.lineWidth = w; ctx.stroke(); }
    }
    function disc(at, r, v, fill, edge) {
      const [x, y] = v.to(at);
      ctx.beginPath();
      ctx.arc(x, y, r * v.s, 0, 2 * Math.PI);
      paint(fill, edge);
    }
    function arrow(from, to, v, tone, w) {
      const [x0, y0] = v.to(from), [x1, y1] = v.to(to);
      const long = Math.hypot(x1 - x0, y1 - y0);
      if (long < 3) return;
      const [ux, uy] = [(x1 - x0) / long, (y1 - y0) / long], h = Math.min(7, 0.5 * long);
      ctx.beginPath();
      ctx.moveTo(x0, y0);
      ctx.lineTo(x1 - h * ux, y1 - h * uy);
      paint(null, tone, w);
      ctx.beginPath();
      ctx.moveTo(x1, y1);
      ctx.lineTo(x1 - h * ux - 0.5 * h * uy, y1 - h * uy + 0.5 * h * ux);
      ctx.lineTo(x1 - h * ux + 0.5 * h * uy, y1 - h * uy - 0.5 * h * ux);
      ctx.closePath();
      paint(tone, null);
    }
    return { path, smooth, paint, disc, arrow };
  }

  return { create, makeView, convexHull };
})();
