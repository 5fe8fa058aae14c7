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
  const piece = 4096, ahead = 0.01; // samples; [s] between a piece's making and its hearing
  let context = null, on = false;

  /* state of the modes after a pulse of force [N], one value each dt [s]: pointers that turn and
   * shrink by one complex product a sample */
  function modesOf(pulse, dt, rate) {
    const modes = [];
    for (let k = 1; k <= 24; k++) {
      const f = k * pitch * Math.sqrt(1 + stiffness * k * k), w = 2 * Math.PI * f;
      if (f > 0.45 * rate) break;
      const [ct, st] = [Math.cos(w * dt), -Math.sin(w * dt)];
      let re = 0, im = 0, u = dt, v = 0; // u, v: exp(-i w t) dt
      for (let i = 0; i < pulse.length; i++) {
        re += pulse[i] * u;
        im += pulse[i] * v;
        const next = ct * u - st * v;
        v = st * u + ct * v;
        u = next;
      }
      const shape = loudness * Math.sin(k * Math.PI * strike) / Math.sqrt(k);
      const tau = 0.5 / (1 + 0.35 * k), fall = Math.exp(-1 / (tau * rate));
      modes.push({ x: shape * re, y: shape * im,
                   c: fall * Math.cos(w / rate), s: fall * Math.sin(w / rate) });
    }
    return modes;
  }

  /* the next samples of a tone */
  function pour(modes, out) {
    for (const m of modes) {
      let { x, y } = m;
      const { c, s } = m;
      for (let i = 0; i < out.length; i++) {
        out[i] += y;
        [x, y] = [c * x - s * y, s * x + c * y];
      }
      [m.x, m.y] = [x, y];
    }
    return out;
  }

  /* A tone for play: it swells for 64 samples, so that there is no click. Piece by piece, because
   * all of it at once would take the time of a frame. */
  function* pieces(pulse, dt, rate) {
    const modes = modesOf(pulse, dt, rate), all = Math.floor(seconds * rate);
    for (let from = 0; from < all; from += piece) {
      const out = pour(modes, new Float32Array(Math.min(piece, all - from)));
      for (let i = 0; from === 0 && i < 64; i++) out[i] *= i / 64;
      yield out;
    }
  }

  function play(pulse, dt) {
    if (!on || !context) return;
    const rate = context.sampleRate, rest = pieces(pulse, dt, rate);
    let at = Math.ceil((context.currentTime + ahead) * rate); // [samples]
    const next = () => {
      const { value, done } = rest.next();
      if (done || !on) return;
      const buffer = context.createBuffer(1, value.length, rate), source = context.createBufferSource();
      buffer.copyToChannel(value, 0);
      source.buffer = buffer;
      source.connect(context.destination);
      source.start(at / rate);
      at += value.length;
      setTimeout(next, 10); // sooner than it is heard
    };
    next();
  }

  /* resolved when it is so; a browser may not allow sound before the page was touched */
  async function turn(wanted) {
    on = wanted;
    if (on && !context) context = new (window.AudioContext || window.webkitAudioContext)();
    if (on) await context.resume();
  }

  return { pieces, play, turn };
})();
