/* SPDX-License-Identifier: MIT
 * tour.js - out of regulation, and back: four steps that each wait for a stroke.
 *
 *   1  a stroke as it should be        3  the stop is turned until the hammer escapes near the string
 *   2  the stop is displaced           4  what was found */
"use strict";

const Tour = (() => {
  const mm = 1e-3, displaced = 0.25 * mm, near = [1 * mm, 4 * mm]; // escapement below the string

  /* box, text, next: elements; strokes: list of strokes; turn(dx) the stop to a place */
  function create({ box, text, next, strokes, turn }) {
    let step = 0, count = 0;

    const regulated = (s) => s.impacts > 0 && s.escapeTime < s.impactTime && s.escapeHeight > near[0] && s.escapeHeight < near[1];
    const done = [null, (s) => s.impacts > 0, () => true, regulated, null];

    function go(n, ...args) {
      step = n;
      count = strokes.length;
      box.hidden = n === 0;
      if (n === 0) return;
      text.textContent = Words.t(`tour${n}`, ...args);
      next.textContent = Words.t(n === 4 ? "tourEnd" : "tourStop");
      if (n === 2) turn(displaced);
    }

    return {
      step: () => step,
      start() { turn(0); go(1); },
      stop() { go(0); },
      /* after every frame: has a new stroke ended that takes it on? */
      follow() {
        const s = strokes[strokes.length - 1];
        if (!done[step] || strokes.length === count || !s.over) return;
        count = strokes.length;
        if (done[step](s)) go(step + 1, (s.escapeHeight / mm).toFixed(1), (s.dx / mm).toFixed(2).replace("-", "−"));
      },
    };
  }

  return { create };
})();
