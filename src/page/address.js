/* SPDX-License-Identifier: MIT
 * address.js - the settings of the page behind the # of its address, so that a link has them:
 * #lang=de&speed=40&pawl.stop_shift=-0.0003 (numbers in SI units). */
"use strict";

const Address = (() => {
  const read = () => new URLSearchParams(location.hash.slice(1));
  return {
    get: (name) => read().get(name),
    /* a number between two, or null */
    number(name, from, to) {
      const text = read().get(name), v = text === null || text === "" ? NaN : Number(text);
      return Number.isFinite(v) ? Math.min(Math.max(v, from), to) : null;
    },
    /* null takes it out */
    put(name, value) {
      const all = read();
      if (value === null) all.delete(name);
      else all.set(name, typeof value === "number" ? String(Number(value.toPrecision(6))) : value);
      history.replaceState(null, "", "#" + all);
    },
  };
})();
