/* SPDX-License-Identifier: MIT
 * traces.js - output channels over the last moments, as lanes that scroll. */
"use strict";

const Traces = (() => {
  const roman = ["–", "i", "ii", "iii", "iv"];
  const words = (name) => Words.of(name.replace(/_/g, " "));

  /* which channels share a lane */
  function lanesOf(model) {
    const all = model.channels.map((c, i) => ({ ...c, i }));
    if (model.string >= 0) {
      const is = (read, index) => all.filter((c) => c.read === read && c.index === index);
      const lanes = [
        { title: Words.t("headToString"), list: is("gap", model.string) },
        { title: Words.t("notchPhase"), list: is("notch_phase", model.notch), phase: true },
        { title: Words.t("forces"), list: all.filter((c) => ["force", "notch_force"].includes(c.read)) },
      ];
      return lanes.filter((lane) => lane.list.length > 0);
    }
    const lanes = [];
    for (const c of all.slice(1)) {
      const lane = lanes.find((k) => k.list[0].unit === c.unit && k.list.length < 3);
      if (lane) lane.list.push(c);
      else if (lanes.length < 4) lanes.push({ title: "", list: [c] });
    }
    return lanes;
  }

  function create(canvas, model, legend) {
    const ctx = canvas.getContext("2d"), lanes = lanesOf(model);
    let width = 0, height = 0, colour = {};
    const range = model.channels.map(() => [Infinity, -Infinity]);
    const gutter = 46, low = 16;
    let seen = 0; // rows of the trace

    lanes.forEach((lane) => lane.list.forEach((c, k) => {
      const item = document.createElement("li");
      item.innerHTML = `<i class="swatch tone${k}"></i><span></span> <b></b>`;
      item.querySelector("span").textContent = words(c.name);
      legend.append(item);
      c.shown = item.querySelector("b");
    }));

    function bounds(lane) {
      if (lane.phase) return [-0.4, 4.4];
      let [a, b] = [Infinity, -Infinity];
      for (const c of lane.list) { a = Math.min(a, range[c.i][0]); b = Math.max(b, range[c.i][1]); }
      if (!(a < b)) { // it has never changed
        const middle = Number.isFinite(a) ? a : 0;
        const half = Math.max(0.1 * Math.abs(middle), 1 / Format.unit(lane.list[0].unit)[0]);
        [a, b] = [middle - half, middle + half];
      }
      return [a - 0.06 * (b - a), b + 0.06 * (b - a)];
    }

    function ticks(lane, a, b) {
      if (lane.phase) return roman.map((t, i) => [i, t]);
      const [factor] = Format.unit(lane.list[0].unit), rough = (b - a) * factor / 5;
      const ten = 10 ** Math.floor(Math.log10(rough));
      const step = ten * [1, 2, 5, 10].find((m) => m * ten >= rough);
      const list = [];
      for (let k = Math.ceil(a * factor / step); k * step <= b * factor; k++)
        list.push([k * step / factor, String(+(k * step).toPrecision(6)).replace("-", "−")]);
      return list;
    }

    function frame(lane, top, Y, a, b) {
      ctx.strokeStyle = colour.rule;
      ctx.fillStyle = colour.muted;
      ctx.lineWidth = 1;
      ctx.font = `11px ${colour.font}`;
      ctx.textAlign = "right";
      for (const [at, name] of ticks(lane, a, b)) {
        const y = Math.round(Y(at)) + 0.5;
        ctx.beginPath();
        ctx.moveTo(gutter, y);
        ctx.lineTo(width, y);
        ctx.stroke();
        ctx.fillText(name, gutter - 6, y + 4);
      }
      ctx.textAlign = "left";
      const unit = lane.phase ? "" : Format.unit(lane.list[0].unit)[1];
      const title = lane.title || lane.list.map((c) => words(c.name)).join(", ");
      ctx.fillStyle = colour.ink;
      ctx.fillText(title + (unit ? ` [${unit}]` : ""), gutter + 6, top + 12);
    }

    function curve(c, trace, end, span, Y, lane) {
      const rows = Math.min(trace.n, trace.rows), w = trace.width;
      const row = (n) => (n % trace.rows) * w;
      ctx.beginPath();
      let y0 = null;
      for (let n = trace.n - rows; n < trace.n; n++) {
        const t = trace.at[row(n)];
        if (t < end - span || t > end) continue;
        const x = width - (end - t) / span * (width - gutter), y = Y(trace.at[row(n) + c.i]);
        if (y0 === null) ctx.moveTo(x, y);
        else if (lane.phase) { ctx.lineTo(x, y0); ctx.lineTo(x, y); }
        else ctx.lineTo(x, y);
        y0 = y;
      }
      ctx.stroke();
    }

    /* a frozen stroke, from where the present one began; up to the time `last` */
    function under(c, old, end, span, Y, opened, last = end) {
      ctx.beginPath();
      let pen = false;
      for (const s of old.samples) {
        const t = s.t - old.opened + opened;
        if (t < end - span || t > last) continue;
        const x = width - (end - t) / span * (width - gutter), y = Y(s.values[c.i]);
        if (pen) ctx.lineTo(x, y);
        else ctx.moveTo(x, y);
        pen = true;
      }
      ctx.stroke();
    }

    /* a measured record, from where the present stroke began */
    function dots(c, record, end, span, Y, opened) {
      if (!record.channels.includes(c.i)) return;
      ctx.fillStyle = colour.ink;
      for (const s of record.samples) {
        const t = s.t + opened, y = Y(s.values[c.i]);
        if (t >= end - span && t <= end && Number.isFinite(y))
          ctx.fillRect(width - (end - t) / span * (width - gutter) - 0.75, y - 0.75, 1.5, 1.5);
      }
    }

    /* the moment that is looked at again */
    function cursor(t, end, span) {
      const x = Math.round(width - (end - t) / span * (width - gutter)) + 0.5;
      if (x < gutter) return;
      ctx.strokeStyle = colour.ink;
      ctx.lineWidth = 1;
      ctx.beginPath();
      ctx.moveTo(x, 0);
      ctx.lineTo(x, height - low);
      ctx.stroke();
    }

    /* what the lanes have to have room for: peaks between two frames too */
    function learn(trace) {
      for (let n = Math.max(seen <= trace.n ? seen : 0, trace.n - trace.rows); n < trace.n; n++) {
        const row = (n % trace.rows) * trace.width;
        range.forEach((r, i) => {
          const v = trace.at[row + i];
          if (v < r[0]) r[0] = v;
          if (v > r[1]) r[1] = v;
        });
      }
      seen = trace.n;
    }

    /* now: channels that are shown; replay: { frozen, measured, samples, opened, at }, at null: no replay */
    function draw(trace, span, now, replay) {
      learn(trace);
      const ratio = canvas.width / width;
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      ctx.clearRect(0, 0, width, height);
      const newest = trace.n > 0 ? trace.at[((trace.n - 1) % trace.rows) * trace.width] : 0;
      const end = replay.at === null ? newest : Math.min(newest, replay.at + 0.5 * span);
      const weights = lanes.map((lane) => (lane.phase ? 0.7 : 1));
      const sum = weights.reduce((x, y) => x + y, 0);
      let top = 0;
      lanes.forEach((lane, l) => {
        const tall = (height - low) * weights[l] / sum, [a, b] = bounds(lane);
        const Y = (v) => top + 18 + (tall - 26) * (1 - (v - a) / (b - a));
        frame(lane, top, Y, a, b);
        ctx.strokeStyle = colour.muted;
        ctx.lineWidth = 1.2;
        for (const old of replay.frozen)
          for (const c of lane.list) under(c, old, end, span, Y, replay.opened);
        for (const record of replay.measured)
          for (const c of lane.list) dots(c, record, end, span, Y, replay.opened);
        if (replay.at !== null) cursor(replay.at, end, span);
        lane.list.forEach((c, k) => {
          ctx.strokeStyle = colour.tones[k % colour.tones.length];
          ctx.lineWidth = 1.6;
          if (replay.at !== null && trace.n > trace.rows) // older than the trace
            under(c, replay, end, span, Y, replay.opened, trace.at[(trace.n % trace.rows) * trace.width]);
          if (trace.n > 1) curve(c, trace, end, span, Y, lane);
          c.shown.textContent = lane.phase ? roman[now[c.i]] : Format.quantity(now[c.i], c.unit);
        });
        top += tall;
      });
      ctx.fillStyle = colour.muted;
      ctx.textAlign = "right";
      if (end === newest) ctx.fillText(Words.t("now"), width, height - 3);
      ctx.textAlign = "left";
      if (end === newest) ctx.fillText("−" + Format.quantity(span, "s"), gutter, height - 3);
    }

    return {
      draw,
      empty: lanes.length === 0,
      fit(cssWidth, ratio) {
        [width, height] = [cssWidth, 40 + (cssWidth > 480 ? 138 : 108) * lanes.length];
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
        canvas.style.height = height + "px";
      },
      theme(tones) { colour = tones; },
      learn,
    };
  }

  return { create };
})();
