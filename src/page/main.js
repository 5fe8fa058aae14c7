/* SPDX-License-Identifier: MIT
 * main.js - the page: controls, the loop of frames, what is learnt from a first run. */
"use strict";

const Page = (() => {
  const $ = (id) => document.getElementById(id);
  const frameTime = 1 / 60, patience = 9; // [s] of a frame, [ms] of it that may be simulated
  const turnTime = 0.06;  // [s] of the mechanism's time from one end of a dial to the other
  const still = 2e-3;     // [rad/s or m/s] slower is at rest ...
  const stillFor = 0.12;  // [s] ... when it lasts so long
  const model = JSON.parse($("model").textContent);
  const perFrame = { mean: 0, least: Infinity, frames: 0 }; // [ms] of simulation in 1/60 s
  let engine, geometry, scene, traces, strokes;
  let speed = 1, carry = 0, last = 0, quiet = 0, asleep = false, failed = false, seenMove = false;
  const held = model.inputs.map(() => false); // pressed inputs
  let touch = 1;                              // [N or N m] of a press

  /* ---- what the mechanism does, before anyone touches it ---- */

  function tangentOf(pair) { // where along the line of a contact the other side is
    const s = geometry.spot(pair);
    if (!s.b.n) return 0;
    return (s.at[0] - s.b.at[0]) * s.b.t[0] + (s.at[1] - s.b.at[1]) * s.b.t[1];
  }

  function preview() {
    const steps = Math.min(Math.round(model.until / model.dt), 40000), looks = 160;
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    const travel = model.contacts.map((c) => c.spots.map(() => [Infinity, -Infinity]));
    const centres = model.bodies.map(() => null), guides = model.bodies.map(() => null);
    const include = (p, r = 0) => {
      [box[0], box[1]] = [Math.min(box[0], p[0] - r), Math.min(box[1], p[1] - r)];
      [box[2], box[3]] = [Math.max(box[2], p[0] + r), Math.max(box[3], p[1] + r)];
    };
    const look = () => {
      geometry.place(engine.q());
      traces.learn(engine.trace());
      model.bodies.forEach((b, i) => {
        if (b.load) return;
        const o = geometry.local(i, 0, 0);
        include(o);
        include(geometry.at(i, geometry.vec(b.centre)));
        centres[i] = centres[i] || o;
        const slides = (k) => model.bodies[k]?.type === "T";
        const alone = !slides(b.parent) && !model.bodies.some((c, k) => c.parent === i && slides(k));
        if (b.type === "T" && alone) guides[i] = [centres[i], o];
      });
      model.points.forEach((p) => include(geometry.at(p.body, geometry.vec(p.at))));
      model.notches.forEach((k) => { const n = geometry.notch(k); include(n.corner); });
      model.contacts.forEach((c, i) => c.spots.forEach((pair, k) => {
        const s = geometry.spot(pair), t = tangentOf(pair), r = travel[i][k];
        travel[i][k] = [Math.min(r[0], t), Math.max(r[1], t)];
        if (!c.load) include(s.a.at, s.a.radius || 0);
        if (!c.load && !s.b.n) include(s.b.at, s.b.radius);
        if (i === model.string) include([s.a.at[0], s.b.at[1]]);
      }));
    };
    engine.reset();
    look();
    for (let n = 0; n < looks; n++) {
      engine.advance(Math.max(1, Math.round(steps / looks)));
      look();
    }
    const size = Math.max(box[2] - box[0], box[3] - box[1], 0.02);
    const room = (scene.action ? 0.02 : 0.25) * size;
    for (const side of [0, 1]) // flat things need air
      if (box[side + 2] - box[side] < 0.3 * size) {
        const add = (0.3 * size - (box[side + 2] - box[side])) / 2;
        box[side] -= add;
        box[side + 2] += add;
      }
    travel.forEach((c) => c.forEach((r) => { r[0] -= room; r[1] += room; }));
    scene.learn({ box, travel, guides: guides.filter((k) => k) });
    startState();
  }

  /* as it lies there before it is played: the load beside it */
  function startState() {
    engine.reset();
    if (hasLoad()) engine.load(false);
    geometry.place(engine.q());
  }
  const hasLoad = () => model.bodies.some((b) => b.load);
  const forceInputs = () => model.inputs.map((k, i) => ({ ...k, i })).filter((k) => k.kind !== "motion");
  const plays = () => hasLoad() || forceInputs().length > 0;

  /* ---- the loop ---- */

  function wake() {
    quiet = 0;
    if (asleep) last = performance.now();
    asleep = false;
  }

  function fail(error) {
    failed = true;
    $("failure").hidden = false;
    $("failure").textContent = `It came apart: ${error.message}. Start again, or turn the last dial back.`;
  }

  function simulate(seconds) {
    const t0 = performance.now();
    let steps = seconds * speed / model.dt + carry;
    carry = steps % 1;
    steps = Math.floor(steps);
    const chunk = 200;
    while (steps > 0 && performance.now() - t0 < patience) {
      engine.advance(Math.min(chunk, steps));
      steps -= chunk;
    }
    if (seconds < 0.5 * frameTime) return;
    const cost = (performance.now() - t0) * frameTime / seconds;
    perFrame.frames++;
    perFrame.mean += (cost - perFrame.mean) / Math.min(perFrame.frames, 30);
    perFrame.least = speed === 1 ? Math.min(perFrame.least, cost) : Infinity;
  }

  function rest(seconds) { // nothing moves: nothing is computed until someone touches it
    quiet = engine.stir() < still ? quiet + seconds * speed : 0;
    asleep = quiet > stillFor && !strokes.isOpen();
  }

  function frame(now) {
    const seconds = Math.min((now - last) / 1e3, 3 * frameTime);
    last = now;
    if (!asleep && !failed && seconds > 0) {
      try {
        simulate(seconds);
        strokes.follow(held.some((h) => h) || engine.loadPresent());
        const pulse = engine.pulse();
        if (pulse) Sound.play(pulse, model.dt);
        rest(seconds);
      } catch (error) {
        fail(error);
      }
      show();
    }
    requestAnimationFrame(frame);
  }

  function takeParameters() {
    for (const d of model.dials) {
      geometry.params[d.param] = engine.value(d.param);
      d.show();
    }
  }

  const roman = ["", "phase i, the beak’s tip on the roof", "phase ii, the beak’s face on the roof",
                 "phase iii, the beak’s face on the corner", "phase iv, the beak’s tip on the pawl"];
  function describeState() {
    const phase = engine.phase(), open = strokes.isOpen();
    const time = `${(1e3 * (engine.time() - (open ? engine.stroke().opened : 0))).toFixed(1)} ms`;
    const cost = `${perFrame.mean.toFixed(1)} ms`;
    const costs = innerWidth < 640 ? `${cost} a frame` : `a frame takes ${cost} to compute`;
    return (phase > 0 ? `${roman[phase]} · ` : "") +
      (asleep ? "at rest" : `${time}${open ? " into the stroke" : ""} · ${costs}`);
  }
  function hint() {
    if (forceInputs().length === 0) return hasLoad() ? "Let the load go." : "";
    return scene.action ? "Hold the space bar, or press the key with finger or mouse."
      : "Hold the space bar, or press on the drawing.";
  }

  function show() {
    takeParameters();
    geometry.place(engine.q());
    const now = { forces: engine.forces(), loadPresent: engine.loadPresent(), phase: engine.phase(),
                  pushes: model.inputs.map((k, i) => (held[i] ? touch : 0)),
                  atRest: asleep || !seenMove };
    scene.draw(now);
    const values = engine.channels();
    traces.draw(engine.trace(), model.until, values);
    strokes.draw();
    $("state").textContent = seenMove ? describeState() : hint();
    $("state").classList.toggle("hint", !seenMove);
    $("table-empty").hidden = strokes.list.length > 0;
  }

  /* ---- playing ---- */

  function press(i, on, force = touch) {
    if (held[i] === on && !on) return;
    if (on && !held[i]) {
      if (!strokes.isOpen() || engine.armed()) strokes.begin();
      moved();
    }
    held[i] = on;
    engine.push(i, on ? force : 0, touch / 0.008);
    for (const b of document.querySelectorAll(`[data-input="${i}"]`)) b.setAttribute("aria-pressed", on);
    wake();
  }

  function dropLoad() {
    const on = !engine.loadPresent();
    if (on) strokes.begin();
    engine.load(on);
    $("load").setAttribute("aria-pressed", on);
    $("load-words").textContent = on ? "Take the load away" : letGo();
    moved();
    wake();
  }
  function letGo() {
    const mass = geometry.num(model.bodies.find((b) => b.load).mass);
    return `Let ${Format.quantity(mass, "kg")} go${scene.action ? " on the key" : ""}`;
  }

  function again() {
    failed = false;
    $("failure").hidden = true;
    strokes.forget();
    try {
      startState();
    } catch (error) {
      fail(error);
    }
    held.fill(false);
    if (hasLoad()) {
      $("load").setAttribute("aria-pressed", false);
      $("load-words").textContent = letGo();
    }
    if (!plays()) moved();
    wake();
    show();
  }

  function moved() {
    seenMove = true;
  }

  function addButton(label, key, className) {
    const b = document.createElement("button");
    b.type = "button";
    b.className = className;
    const words = document.createElement("span");
    words.textContent = label;
    b.append(words);
    if (key) {
      const k = document.createElement("kbd");
      k.textContent = key;
      b.append(k);
    }
    $("actions").append(b);
    return b;
  }

  function holdButton(b, i) {
    b.dataset.input = i;
    b.setAttribute("aria-pressed", "false");
    b.addEventListener("pointerdown", (e) => { b.setPointerCapture(e.pointerId); press(i, true); });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      b.addEventListener(end, () => press(i, false));
    b.addEventListener("keydown", (e) => {
      if ((e.key === " " || e.key === "Enter") && !e.repeat) press(i, true);
      if (e.key === " " || e.key === "Enter") e.preventDefault();
    });
    b.addEventListener("keyup", (e) => {
      if (e.key === " " || e.key === "Enter") { press(i, false); e.preventDefault(); }
    });
    b.addEventListener("blur", () => press(i, false));
    b.addEventListener("contextmenu", (e) => e.preventDefault());
  }

  function buildActions() {
    forceInputs().slice(0, 3).forEach((input, n) => {
      const words = scene.action ? "Press the key" : `Hold to push: ${input.name.replace(/_/g, " ")}`;
      holdButton(addButton(words, n === 0 ? "space" : "", "main"), input.i);
    });
    if (hasLoad()) {
      const b = addButton("", "L", "");
      b.id = "load";
      b.setAttribute("aria-pressed", "false");
      b.querySelector("span").id = "load-words";
      b.addEventListener("click", dropLoad);
      $("load-words").textContent = letGo();
    }
    $("again").addEventListener("click", again);
  }

  /* the harder one drags down, the harder one presses */
  function buildStage() {
    const c = $("stage");
    let input = -1, y0 = 0;
    c.addEventListener("pointerdown", (e) => {
      const box = c.getBoundingClientRect();
      const [x, y] = [e.clientX - box.left, e.clientY - box.top];
      const weight = scene.weightAt(engine.loadPresent());
      if (weight && Math.abs(x - weight[0]) < weight[2] && Math.abs(y - weight[1]) < weight[3]) {
        dropLoad();
        return;
      }
      input = scene.inputAt(x, y);
      if (input < 0 && forceInputs().length > 0) input = forceInputs()[0].i;
      if (input < 0) return;
      y0 = e.clientY;
      c.setPointerCapture(e.pointerId);
      press(input, true);
    });
    c.addEventListener("pointermove", (e) => {
      if (input >= 0 && held[input])
        press(input, true, touch * Math.max(0.2, Math.min(4, 1 + (e.clientY - y0) / 60)));
    });
    for (const end of ["pointerup", "pointercancel"])
      c.addEventListener(end, () => { if (input >= 0) press(input, false); input = -1; });
  }

  function buildKeys() {
    const first = forceInputs()[0];
    const busy = (e) => e.ctrlKey || e.metaKey || e.altKey || $("help").open;
    document.addEventListener("keydown", (e) => {
      if (busy(e)) return;
      const name = e.key.toLowerCase(); // whatever Caps Lock says
      if (name === " " && first && !e.target.closest("button")) { // a slider has no use for it
        if (!e.repeat) press(first.i, true);
        e.preventDefault();
      } else if (name === "l" && hasLoad() && !e.repeat) dropLoad();
      else if (name === "r" && !e.repeat) again();
      else if (name === "?") openHelp();
    });
    document.addEventListener("keyup", (e) => {
      if (e.key === " " && first && held[first.i]) press(first.i, false);
    });
    window.addEventListener("blur", () => held.forEach((h, i) => { if (h) press(i, false); }));
  }

  /* ---- dials ---- */

  function addSlider({ label, about, unit, from, to, value, turn }) {
    const row = document.createElement("div"), id = "dial" + $("dials").children.length;
    row.className = "dial";
    row.innerHTML = `<label for="${id}"></label><output for="${id}"></output>` +
      `<button type="button">reset</button><div class="range"><input id="${id}" type="range" min="0" ` +
      `max="1000" step="1"><i class="now"></i></div>`;
    const [input, output, now] = ["input", "output", ".now"].map((s) => row.querySelector(s));
    row.querySelector("label").textContent = label;
    row.querySelector("button").setAttribute("aria-label", `Reset ${label}`);
    if (about) row.title = about;
    const at = (v) => 1000 * (v - from) / (to - from);
    const put = (v) => {
      output.textContent = Format.quantity(v, unit);
      input.setAttribute("aria-valuetext", output.textContent);
      row.classList.toggle("turned", Math.abs(v - value) > 1e-3 * (to - from));
    };
    input.value = at(value);
    input.addEventListener("input", () => {
      const v = from + (to - from) * input.value / 1000;
      put(v);
      turn(v);
    });
    row.querySelector("button").addEventListener("click", () => {
      input.value = at(value);
      put(value);
      turn(value);
      input.focus();
    });
    put(value);
    $("dials").append(row);
    return { show(v) { now.style.left = `calc(0.5rem + (100% - 1rem) * ${at(v) / 1000})`; } };
  }

  function buildDials() {
    const abouts = new Map(model.abouts.map((a) => [a.entry, a.text]));
    for (const d of model.dials) {
      const slider = addSlider({
        ...d, value: model.values[d.param], about: abouts.get(d.name),
        turn(v) {
          engine.aim(d.param, v, (d.to - d.from) / turnTime);
          if (!plays()) moved();
          wake();
        },
      });
      let shown = NaN;
      d.show = () => {
        const v = geometry.params[d.param];
        if (v !== shown) slider.show(v);
        shown = v;
      };
    }
    const first = forceInputs()[0];
    if (!first) return;
    const weight = 9.81 * model.bodies.reduce((m, b) => m + (b.load ? 0 : geometry.num(b.mass)), 0);
    const reach = first.kind === "point" ? 1 : 0.1;
    touch = weight * reach;
    const slider = addSlider({
      label: scene.action ? "finger" : "push", unit: first.unit, from: 0.1 * touch, to: 5 * touch,
      value: touch, turn(v) { touch = v; slider.show(v); },
    });
    slider.show(touch);
  }

  /* ---- speed, sound, help, looks ---- */

  function buildSpeed() {
    // 0 .. 100: from a five-hundredth to real time; round numbers on the way
    const factor = (s) => 500 ** (s / 100 - 1);
    const words = (f) => (f > 0.995 ? "real time" : `1/${Number((1 / f).toPrecision(2))} of real time`);
    const turn = () => {
      const f = factor(+$("speed").value);
      speed = f > 0.995 ? 1 : 1 / Number((1 / f).toPrecision(2));
      $("speed-shown").textContent = words(speed);
      $("speed").setAttribute("aria-valuetext", words(speed));
    };
    const wish = Math.min(1, model.until / 6); // the file's own run in six seconds
    $("speed").value = Math.round(100 * (1 + Math.log(wish) / Math.log(500)));
    $("speed").addEventListener("input", turn);
    turn();
  }

  function buildSound() {
    const b = $("sound");
    b.hidden = model.string < 0;
    b.addEventListener("click", () => {
      const on = b.getAttribute("aria-pressed") !== "true";
      Sound.turn(on);
      b.setAttribute("aria-pressed", on);
      b.textContent = on ? "Sound on" : "Sound off";
    });
  }

  function openHelp() {
    $("help").showModal();
    if ($("help-check").textContent) return;
    const here = engine.verify();
    $("help-check").textContent = here === model.hash
      ? `The same numbers to the last bit: ${Format.quantity(model.until, "s")} of this mechanism end in state ${here} here and in the library on the machine that wrote this page.`
      : `State after ${Format.quantity(model.until, "s")} of this mechanism: ${here} here, ${model.hash} in the library.`;
  }

  function buildHelp() {
    $("help-action").hidden = !scene.action;
    if (!scene.action)
      for (const a of model.abouts) {
        if (a.section === "" || a.entry === "") continue;
        const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
        dt.textContent = a.entry.replace(/_/g, " ");
        dd.textContent = a.text;
        $("help-abouts").append(dt, dd);
      }
    const keys = [forceInputs().length > 0 && "hold space to press",
                  hasLoad() && "L puts the load on and takes it away", "R starts again",
                  "Tab goes from slider to slider, arrows turn them"];
    $("help-keys").textContent = "Keys: " + keys.filter((k) => k).join(", ") + ".";
    $("help-open").addEventListener("click", openHelp);
    $("help").addEventListener("click", (e) => { if (e.target === $("help")) $("help").close(); });
  }

  function theme() {
    const css = getComputedStyle(document.documentElement);
    const tone = (name) => css.getPropertyValue("--" + name).trim();
    const colour = { font: tone("sans"), tones: [0, 1, 2, 3].map((i) => tone("tone" + i)) };
    for (const name of ["paper", "panel", "ink", "muted", "rule", "wood", "wood2", "wood3", "edge",
                        "plate", "felt", "leather", "brass", "onbrass", "frame", "string", "force",
                        "finger"]) colour[name] = tone(name);
    for (const part of [scene, traces, strokes]) part.theme(colour);
  }

  function fit() {
    const ratio = Math.min(window.devicePixelRatio || 1, 3);
    const stage = $("stage").parentElement, sticks = getComputedStyle(stage).position === "sticky";
    scene.fit(stage.clientWidth, Math.max(260, 0.62 * innerHeight), ratio);
    // what gets the focus is not scrolled behind it
    document.documentElement.style.scrollPaddingTop = sticks ? `${stage.offsetHeight + 8}px` : "";
    traces.fit($("traces").parentElement.clientWidth, ratio);
    strokes.fit($("chart").parentElement.clientWidth, ratio);
    show();
  }

  function titles() {
    const about = (model.abouts.find((a) => a.section === "") || { text: model.name }).text;
    const cut = about.indexOf(" - "), first = cut < 0 ? about : about.slice(0, cut);
    $("title").textContent = first[0].toUpperCase() + first.slice(1).replace(/\.$/, "");
    $("subtitle").textContent = cut < 0 ? "" : about.slice(cut + 3);
    document.title = $("title").textContent;
    $("foot").textContent = `libstein ${model.version} · mechanism ${model.name}, equations ${model.equations}` +
      ` · step ${Format.quantity(model.dt, "s")} · all that you see is computed in this page.`;
  }

  async function start() {
    const every = Math.max(1, Math.round(model.until / model.dt / 2000));
    engine = await Engine.create($("module").textContent, model, every);
    geometry = Geometry.create(model);
    scene = Scene.create($("stage"), geometry);
    traces = Traces.create($("traces"), model, $("legend"));
    $("traces").parentElement.hidden = traces.empty;
    const dx = model.dials.find((d) => d.name === "pawl.stop_shift");
    $("strokes").hidden = model.string < 0;
    $("chart-section").hidden = !dx || model.string < 0;
    strokes = Strokes.create({ engine, table: $("table"), chart: $("chart"),
                               dial: dx ? dx.param : null, say: (t) => { $("announce").textContent = t; } });
    if (model.string < 0) strokes.begin = strokes.follow = strokes.forget = () => {};
    preview();
    titles();
    buildActions();
    buildStage();
    buildKeys();
    buildDials();
    buildSpeed();
    buildSound();
    buildHelp();
    theme();
    fit();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { theme(); show(); });
    window.addEventListener("resize", fit);
    asleep = plays() && model.settle === 1; // else it moves by itself
    if (!plays()) moved();
    show();
    document.documentElement.dataset.ready = "yes";
    requestAnimationFrame((now) => { last = now; frame(now); });
  }

  start().catch((error) => {
    document.documentElement.dataset.ready = "failed";
    fail(error);
  });

  return { engine: () => engine, strokes: () => strokes, perFrame, geometry: () => geometry,
           scene: () => scene };
})();
