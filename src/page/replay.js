/* SPDX-License-Identifier: MIT
 * replay.js - the samples of the last stroke, for replay, and frozen strokes for comparison. A
 * stroke begins with the last press, load or start. */
"use strict";

const Replay = (() => {
  const most = 3000, kept = 3; // samples of a stroke, frozen strokes

  function create(engine) {
    let samples = [];
    const frozen = [];

    const at = (list, t) => { // the last sample that is not after t, by bisection
      let [a, b] = [0, list.length - 1];
      while (a < b) {
        const m = (a + b + 1) >> 1;
        if (list[m].t <= t) a = m;
        else b = m - 1;
      }
      return list[a];
    };

    return {
      frozen,
      begin() { samples = []; },
      /* add a sample */
      note() {
        if (samples.length === most) samples = samples.slice(most / 2);
        samples.push({ t: engine.time(), q: engine.q().slice(), forces: engine.forces().slice(),
                       load: engine.loadPresent(), phase: engine.phase(),
                       values: engine.channels().slice() });
      },
      samples: () => samples,
      length: () => samples.length,
      sample: (i) => samples[Math.min(i, samples.length - 1)],
      opened: () => (samples.length > 0 ? samples[0].t : engine.time()),
      /* keep the recorded stroke with its parameters */
      freeze(params) {
        if (samples.length < 2) return false;
        frozen.push({ samples, opened: samples[0].t, params: params.slice() });
        if (frozen.length > kept) frozen.shift();
        return true;
      },
      thaw() { frozen.length = 0; },
      /* where frozen strokes were, so long after their beginning */
      ghosts: (since) => frozen.map((f) => ({ params: f.params, ...at(f.samples, f.opened + since) })),
    };
  }

  return { create };
})();
