/* SPDX-License-Identifier: MIT
 * engine.js - the WebAssembly module of shim.c with names and arrays. Independent of the page, so
 * that it runs without a browser too. */
"use strict";

const Engine = (() => {
  const bytesOf = (base64) => Uint8Array.from(atob(base64.trim()), (c) => c.charCodeAt(0));

  /* model: the JSON of the page; every: steps a sample of the trace */
  async function create(base64, model, every) {
    const { instance } = await WebAssembly.instantiate(bytesOf(base64), {});
    const x = instance.exports, np = model.values.length;
    const nchannel = model.channels.length, ncontact = model.contacts.length;

    const doubles = (at, n) => new Float64Array(x.memory.buffer, at, n);
    function text(at) {
      const bytes = new Uint8Array(x.memory.buffer, at);
      return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
    }
    function check(status) {
      if (status !== 0) throw new Error(text(x.page_message()));
    }

    doubles(x.page_open(), np).set(model.values);
    check(x.page_start(model.dt, model.integrator, model.settle, every));

    return {
      model,
      reset: () => check(x.page_reset()),
      advance: (steps) => check(x.page_advance(steps)),
      aim: (i, value, pace) => x.page_aim(i, value, pace),
      value: (i) => x.page_value(i),
      push: (i, value, pace) => x.page_push(i, value, pace),
      load: (on) => check(x.page_load(on ? 1 : 0)),
      loadPresent: () => x.page_load_present() === 1,
      time: () => x.page_time(),
      stir: () => x.page_stir(),
      phase: () => x.page_phase(),
      armed: () => x.page_armed() === 1,
      q: () => doubles(x.page_q(), model.bodies.length),
      channels: () => doubles(x.page_channels(), nchannel),
      forces: () => doubles(x.page_forces(), 2 * (ncontact + model.notches.length)),
      beginStroke: () => x.page_stroke_begin(),
      stroke() {
        const s = doubles(x.page_stroke(), 8);
        return { opened: s[0], escapeTime: s[1], escapeHeight: s[2], impactTime: s[3],
                 impactSpeed: s[4], impacts: s[5], peak: s[6], touched: s[7] > 0 };
      },
      trace() {
        const rows = 4096; // as many as TRACE_ROWS of shim.c, over and over
        return { n: x.page_trace_rows(), rows, width: nchannel,
                 at: doubles(x.page_trace(), rows * nchannel) };
      },
      /* the force on the string since the impact, once */
      pulse() {
        const n = x.page_pulse_length();
        return n > 0 ? doubles(x.page_pulse(), n).slice() : null;
      },
      verify: () => text(x.page_verify(model.until)),
    };
  }

  return { create };
})();
