/* SPDX-License-Identifier: MIT
 * strokes.js - results of each stroke: rows of a table, points of the chart of escapement
 * against the stop's place, with the line of the paper. */
"use strict";

const Strokes = (() => {
  const mm = 1e-3, settled = 0.03; // [s] nothing more is expected after that
  const longest = 0.6;             // [s] a stroke that comes to nothing is given up
  // the paper: escapement 2.2 mm below the string at dx = 0, 20 mm less a millimetre of dx
  const paper = (dx) => 2.2 * mm - 20 * dx;
  const range = { dx: [-1.5 * mm, 0.5 * mm], height: [0, 30 * mm] };

  /* what a stroke is, in a word */
  function outcome(s) {
    if (s.noNotch) return s.impacts > 0 ? "struck" : "no blow";
    if (!s.touched && s.impacts === 0) return "missed the notch";
    if (!Number.isFinite(s.escapeTime)) return s.impacts > 0 ? "struck, not escaped" : "no escapement";
    if (s.impacts === 0) return "escaped, no blow";
    return s.escapeTime > s.impactTime ? "forced" : "struck";
  }

  function isOver(s, time, pressed) {
    const last = Math.max(s.opened, s.escapeTime || 0, s.impactTime || 0);
    if ((s.noNotch || Number.isFinite(s.escapeTime)) && s.impacts > 0) return time - last > settled;
    return time - s.opened > longest || (!pressed && time - s.opened > 0.15);
  }

  function create({ engine, table, chart, dial, say }) {
    const ctx = chart ? chart.getContext("2d") : null, list = [];
    let open = null, width = 0, height = 0, colour = {}, stale = true;

    function addRow(s) {
      const row = document.createElement("tr");
      row.innerHTML = "<td></td>".repeat(6);
      table.prepend(row);
      s.row = row;
    }

    function write(s) {
      const cell = s.row.cells, put = (i, t) => { if (cell[i].textContent !== t) cell[i].textContent = t; };
      put(0, String(s.number));
      put(1, dial === null ? "" : (1e3 * s.dx).toFixed(2).replace("-", "−"));
      put(2, Number.isFinite(s.escapeHeight) ? (1e3 * s.escapeHeight).toFixed(2) : "–");
      put(3, Number.isFinite(s.impactSpeed) ? s.impactSpeed.toFixed(2) : "–");
      put(4, s.peak > 0 ? s.peak.toFixed(2) : "–");
      put(5, s.over ? Words.t(outcome(s)) : "…");
    }

    function begin() {
      if (open) finish();
      engine.beginStroke();
      open = { number: list.length + 1, over: false, ...engine.stroke(),
               noNotch: engine.model.notch < 0,
               dx: dial === null ? NaN : engine.value(dial) };
      list.push(open);
      addRow(open);
      write(open);
    }

    function finish() {
      open.over = true;
      write(open);
      const h = open.escapeHeight;
      say(Words.t("sayStroke", open.number, Words.t(outcome(open))) +
          (Number.isFinite(h) ? Words.t("sayHeight", (1e3 * h).toFixed(1)) : "") +
          (open.peak > 0 ? Words.t("sayPeak", open.peak.toFixed(1)) : "") + ".");
      open = null;
      stale = true;
    }

    function follow(pressed) {
      if (!open) return;
      Object.assign(open, engine.stroke());
      if (dial !== null && !Number.isFinite(open.escapeTime)) open.dx = engine.value(dial);
      write(open);
      stale = true;
      if (isOver(open, engine.time(), pressed)) finish();
    }

    function axes(X, Y) {
      ctx.font = `11px ${colour.font}`;
      ctx.strokeStyle = colour.rule;
      ctx.fillStyle = colour.muted;
      ctx.lineWidth = 1;
      const line = (x0, y0, x1, y1) => {
        ctx.beginPath();
        ctx.moveTo(x0, y0);
        ctx.lineTo(x1, y1);
        ctx.stroke();
      };
      ctx.textAlign = "center";
      for (let k = -3; k <= 1; k++) {
        const x = Math.round(X(0.5 * k * mm)) + 0.5;
        line(x, Y(0), x, Y(range.height[1]));
        ctx.fillText((0.5 * k).toFixed(1).replace("-", "−"), x, Y(0) + 15);
      }
      ctx.textAlign = "right";
      for (let k = 0; k <= 3; k++) {
        const y = Math.round(Y(10 * k * mm)) + 0.5;
        line(X(range.dx[0]), y, X(range.dx[1]), y);
        ctx.fillText(String(10 * k), X(range.dx[0]) - 6, y + 4);
      }
      ctx.fillText(Words.t("stopAxis"), X(range.dx[1]), Y(0) + 30);
      ctx.fillStyle = colour.ink; // above the right end of the line
      ctx.fillText(Words.t("heightAxis"), X(range.dx[1]), Y(range.height[1]) + 12);
    }

    function draw() {
      if (!ctx || !stale) return;
      stale = false;
      const ratio = chart.width / width;
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      ctx.clearRect(0, 0, width, height);
      const X = (dx) => 30 + (width - 40) * (dx - range.dx[0]) / (range.dx[1] - range.dx[0]);
      const Y = (h) => height - 38 - (height - 48) * h / range.height[1];
      axes(X, Y);
      ctx.strokeStyle = colour.tones[1];
      ctx.setLineDash([6, 4]);
      ctx.lineWidth = 1.5;
      ctx.beginPath();
      ctx.moveTo(X(-1.25 * mm), Y(paper(-1.25 * mm)));
      ctx.lineTo(X(0.11 * mm), Y(paper(0.11 * mm)));
      ctx.stroke();
      ctx.setLineDash([]);
      ctx.fillStyle = colour.tones[1];
      ctx.textAlign = "left";
      ctx.fillText(Words.t("paperLine"), X(-0.62 * mm), Y(paper(-0.62 * mm)) - 12);
      for (const s of list) {
        if (!Number.isFinite(s.escapeHeight)) continue;
        ctx.beginPath();
        ctx.arc(X(s.dx), Y(Math.min(s.escapeHeight, range.height[1])), 4.5, 0, 2 * Math.PI);
        ctx.fillStyle = s.escapeTime > s.impactTime ? colour.paper : colour.tones[0];
        ctx.strokeStyle = s === list[list.length - 1] ? colour.ink : colour.tones[0];
        ctx.lineWidth = 1.6;
        ctx.fill();
        ctx.stroke();
      }
    }

    return {
      begin, follow, draw, list,
      isOpen: () => open !== null,
      forget() { if (open) finish(); },
      fit(cssWidth, ratio) {
        if (!ctx) return;
        [width, height] = [cssWidth, Math.round(Math.min(320, 0.75 * cssWidth))];
        chart.width = Math.round(width * ratio);
        chart.height = Math.round(height * ratio);
        chart.style.height = height + "px";
        stale = true;
      },
      theme(tones) { colour = tones; stale = true; },
    };
  }

  return { create, outcome };
})();
