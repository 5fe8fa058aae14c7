/* SPDX-License-Identifier: MIT
 * measured.js - a measured record, a CSV file as docs/data-files.md has it, to be drawn over the
 * traces: its columns are outputs of the model by name, its time counts from the stroke's beginning. */
"use strict";

const Measured = (() => {
  const units = { m: 1, mm: 1e-3, um: 1e-6, "µm": 1e-6, s: 1, ms: 1e-3, us: 1e-6, "µs": 1e-6, rad: 1,
                  mrad: 1e-3, deg: Math.PI / 180, "°": Math.PI / 180, N: 1, mN: 1e-3, "N m": 1,
                  "mN m": 1e-3, "m/s": 1, "mm/s": 1e-3, "rad/s": 1, "deg/s": Math.PI / 180, 1: 1 };

  /* "angle [mrad]", "angle (deg)", "angle" -> name and factor to SI, NaN for an unknown unit */
  function title(text) {
    const m = text.trim().match(/^(.*?)\s*[[(]([^\])]*)[\])]$/), unit = m ? m[2].trim() : "1";
    return { name: (m ? m[1] : text).trim(), factor: m ? units[unit] ?? NaN : 1 };
  }

  /* @return { samples: [{ t, values: { channel: value } }], channels } or throws a message */
  function read(text, model) {
    const lines = text.replace(/^\uFEFF/, "").split(/\r?\n/).filter((l) => l.trim() !== "" && l[0] !== "#");
    const apart = lines.length > 0 && !lines[0].includes(",") ? (lines[0].includes(";") ? ";" : "\t") : ",";
    const titles = (lines.shift() || "").split(apart).map(title);
    const index = titles.map((k) => model.channels.findIndex((c) => c.name === k.name));
    const channels = index.filter((i, k) => k > 0 && i > 0);
    if (channels.length === 0 || titles.length < 2) throw new Error(titles.map((k) => k.name).join(", "));
    const wrong = titles.find((k, n) => (n === 0 || index[n] > 0) && !Number.isFinite(k.factor));
    if (wrong) throw new Error(wrong.name);
    const number = (cell) => (cell === undefined || cell.trim() === "" ? NaN
      : Number(apart === "," ? cell : cell.replace(",", ".")));
    const samples = [];
    for (const line of lines) {
      const cells = line.split(apart), t = titles[0].factor * number(cells[0]), values = {};
      if (!Number.isFinite(t)) throw new Error(line.slice(0, 30));
      index.forEach((i, k) => { if (k > 0 && i > 0) values[i] = titles[k].factor * number(cells[k]); });
      samples.push({ t, values });
    }
    if (samples.length < 2) throw new Error("");
    return { samples, channels, opened: 0 };
  }

  return { read };
})();
