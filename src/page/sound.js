/* SPDX-License-Identifier: MIT
 * sound.js - the string struck: the force that the simulation found drives the modes of a string.
 *
 *   y(t) = sum over n of  a_n(t) sin(w_n t + phase),  decaying as exp(-t / tau_n)
 *
 * A mode's amplitude and phase are those that the force pulse leaves it with, the integral of
 * F(t) exp(-i w_n t), times the mode's shape where the hammer strikes. Partials are a little sharp,
 * as a stiff string's are. */
"use strict";

const Sound = (() => {
  const pitch = 1396.9, stiffness = 4e-4; // F6; w_n = n w_1 sqrt(1 + B n^2)
  const strike = 1 / 9, seconds = 1.6, loudness = 400;
  let context = null, on = false;

  /* samples of the tone that a pulse of force [N], one value each dt [s], leaves behind */
  function tone(pulse, dt, rate) {
    const n = Math.floor(seconds * rate), out = new Float32Array(n);
    for (let k = 1; ; k++) {
      const f = k * pitch * Math.sqrt(1 + stiffness * k * k), w = 2 * Math.PI * f;
      if (f > 0.45 * rate || k > 24) break;
      let [re, im] = [0, 0];
      pulse.forEach((F, i) => {
        re += F * Math.cos(w * i * dt) * dt;
        im -= F * Math.sin(w * i * dt) * dt;
      });
      const shape = loudness * Math.sin(k * Math.PI * strike) / Math.sqrt(k);
      const tau = 0.5 / (1 + 0.35 * k), fall = Math.exp(-1 / (tau * rate));
      // a turning pointer: one complex product a sample
      const [c, s] = [fall * Math.cos(w / rate), fall * Math.sin(w / rate)];
      let [x, y] = [shape * re, shape * im];
      for (let i = 0; i < n; i++) {
        out[i] += y;
        [x, y] = [c * x - s * y, s * x + c * y];
      }
    }
    for (let i = 0; i < 64 && i < n; i++) out[i] *= i / 64; // no click
    return out;
  }

  function play(pulse, dt) {
    if (!on || !context) return;
    const samples = tone(pulse, dt, context.sampleRate);
    const buffer = context.createBuffer(1, samples.length, context.sampleRate);
    buffer.copyToChannel(samples, 0);
    const source = context.createBufferSource();
    source.buffer = buffer;
    source.connect(context.destination);
    source.start();
  }

  function turn(wanted) {
    on = wanted;
    if (on && !context) context = new (window.AudioContext || window.webkitAudioContext)();
    if (on) context.resume();
  }

  return { tone, play, turn };
})();
