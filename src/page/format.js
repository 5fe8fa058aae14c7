/* SPDX-License-Identifier: MIT
 * format.js - numbers for people. */
"use strict";

const Format = (() => {
  const people = {
    "m": [1e3, "mm"], "kg": [1e3, "g"], "rad": [180 / Math.PI, "°"], "s": [1e3, "ms"],
    "N m/rad": [1e3, "mN m/rad"], "N m": [1e3, "mN m"], "rad/s": [1, "rad/s"], "1": [1, ""],
    "kg m^2": [1e7, "g cm²"], "m/s": [1, "m/s"], "N": [1, "N"],
  };

  /* factor and name of the unit to show */
  const unit = (si) => people[si] || [1, si.replace(/\^2/g, "²").replace(/\^3/g, "³")];

  /* a number with so many digits that matter, minus sign and all */
  function digits(x, n = 3) {
    if (!Number.isFinite(x)) return "–";
    if (x === 0) return "0";
    const size = Math.floor(Math.log10(Math.abs(x)) + 1e-9);
    if (size >= 6 || size < -4) return x.toExponential(n - 1).replace("-", "−");
    return x.toFixed(Math.max(0, Math.min(n - 1 - size, 6))).replace("-", "−");
  }

  function quantity(x, si, n = 3) {
    if (si === "s" && x !== 0) {
      const [factor, name] = Math.abs(x) < 1e-3 ? [1e6, "µs"] : Math.abs(x) < 1 ? [1e3, "ms"] : [1, "s"];
      return `${String(+(factor * x).toPrecision(n)).replace("-", "−")} ${name}`;
    }
    const [factor, name] = si === "kg" && Math.abs(x) >= 1 ? [1, "kg"] : unit(si);
    return digits(factor * x, n) + (name === "°" || name === "" ? name : " " + name);
  }

  return { unit, digits, quantity };
})();
