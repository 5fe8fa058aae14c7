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
  let engine, geometry, scene, traces, strokes, replay, tour;
  let paused = false, seen = null; // seen: the sample that is looked at again
  let since = 0;                   // steps after the last sample
  const measured = [];             // records that were opened
  const sampleSteps = Math.max(1, Math.round(model.until / model.dt / 1000));
  let speed = 1, carry = 0, last = 0, quiet = 0, asleep = false, failed = false, seenMove = false;
  const held = model.inputs.map(() => false); // pressed inputs
  let touch = 1;                              // [N or N m] of a press
  let soundChosen = true; // on or off by hand; else the first press turns it on, where that is allowed

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
    $("failure").textContent = Words.t("failed", error.message);
  }

  /* so many steps, with a sample of them now and then */
  function advance(steps) {
    while (steps > 0) {
      const n = Math.min(steps, sampleSteps - since);
      engine.advance(n);
      steps -= n;
      since = (since + n) % sampleSteps;
      if (since === 0) replay.note();
    }
  }

  function simulate(seconds) {
    const t0 = performance.now();
    let steps = seconds * speed / model.dt + carry;
    carry = steps % 1;
    steps = Math.floor(steps);
    const chunk = 200;
    while (steps > 0 && performance.now() - t0 < patience) {
      advance(Math.min(chunk, steps));
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
    if (!asleep && !failed && !paused && seconds > 0) {
      try {
        simulate(seconds);
        strokes.follow(held.some((h) => h) || engine.loadPresent());
        tour.follow();
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

  const milliseconds = (s) => `${(1e3 * s).toFixed(1)} ms`;
  function describeState(phase) {
    const open = strokes.isOpen();
    const time = milliseconds(engine.time() - (open ? engine.stroke().opened : 0));
    const cost = `${perFrame.mean.toFixed(1)} ms`;
    const costs = Words.t(innerWidth < 640 ? "costsShort" : "costs", cost);
    const words = paused ? Words.t("paused", milliseconds((seen ? seen.t : engine.time()) - replay.opened()))
      : asleep ? Words.t("atRest") : `${open ? Words.t("into", time) : time} · ${costs}`;
    return (phase > 0 ? `${Words.t(`phase${phase}`)} · ` : "") + words;
  }
  function hint() {
    if (forceInputs().length === 0) return hasLoad() ? Words.t("hintLoad") : "";
    return Words.t(scene.action ? "hintKey" : "hintPush");
  }

  const present = () => ({ t: engine.time(), q: engine.q(), forces: engine.forces(), load: engine.loadPresent(),
                           phase: engine.phase(), values: engine.channels() });

  function show() {
    takeParameters();
    const s = seen || present();
    geometry.place(s.q);
    scene.draw({ q: s.q, forces: s.forces, loadPresent: s.load, phase: s.phase,
                 ghosts: replay.ghosts(s.t - replay.opened()),
                 pushes: model.inputs.map((k, i) => (held[i] && !seen ? touch : 0)),
                 named: asleep || !seenMove || paused });
    traces.draw(engine.trace(), model.until, s.values,
                { frozen: replay.frozen, measured, samples: replay.samples(), opened: replay.opened(),
                  at: seen ? seen.t : null });
    strokes.draw();
    showScrub();
    $("state").textContent = seenMove ? describeState(s.phase) : hint();
    $("state").classList.toggle("hint", !seenMove);
    $("table-empty").hidden = strokes.list.length > 0;
  }

  /* ---- pause, single steps, the last stroke again ---- */

  function showScrub() {
    const n = replay.length(), bar = $("scrub");
    bar.disabled = n < 2;
    bar.max = Math.max(1, n - 1);
    bar.value = seen ? seen.i : bar.max;
    $("scrub-shown").textContent = n < 2 ? "" : milliseconds((seen ? seen.t : engine.time()) - replay.opened());
    bar.setAttribute("aria-valuetext", $("scrub-shown").textContent);
  }

  function pause(on) {
    paused = on;
    if (!on) seen = null;
    $("pause").setAttribute("aria-pressed", on);
    $("pause").textContent = Words.t(on ? "goOn" : "pause");
    wake();
    show();
  }

  function oneStep() {
    seen = null;
    if (!paused) pause(true);
    try {
      advance(sampleSteps);
      strokes.follow(held.some((h) => h) || engine.loadPresent());
    } catch (error) {
      fail(error);
    }
    moved();
    show();
  }

  function buildReplay() {
    $("scrub-words").textContent = Words.t(model.string < 0 ? "lastMotion" : "lastStroke");
    $("step").textContent = Words.t("step", Format.quantity(sampleSteps * model.dt, "s"));
    $("pause").addEventListener("click", () => pause(!paused));
    $("step").addEventListener("click", oneStep);
    $("scrub").addEventListener("input", () => {
      const i = +$("scrub").value;
      if (!paused) pause(true);
      seen = { i, ...replay.sample(i) };
      show();
    });
    const count = () => {
      $("thaw").hidden = replay.frozen.length === 0;
      $("thaw").textContent = Words.t("thaw", replay.frozen.length);
    };
    $("freeze").addEventListener("click", () => {
      if (replay.freeze(geometry.params)) $("announce").textContent = Words.t("frozen");
      count();
      show();
    });
    $("thaw").addEventListener("click", () => { replay.thaw(); count(); $("freeze").focus(); show(); });
  }

  function buildTour(stop) {
    tour = Tour.create({ box: $("tour"), text: $("tour-text"), next: $("tour-next"), strokes: strokes.list,
                         turn: (dx) => stop.take(dx) });
    $("tour-start").hidden = !scene.action || !stop;
    $("tour-start").addEventListener("click", () => tour.start());
    $("tour-next").addEventListener("click", () => { tour.stop(); $("tour-start").focus(); fit(); });
  }

  /* ---- measured records ---- */

  async function openRecords(files) {
    const words = [];
    measured.length = 0;
    for (const file of files)
      try {
        measured.push(Measured.read(await file.text(), model));
        words.push(Words.t("opened", file.name));
      } catch (error) {
        words.push(Words.t("notOpened", file.name, error.message));
      }
    $("measured").textContent = $("announce").textContent = words.join(" ");
    show();
  }

  function buildMeasured() {
    $("open").textContent = Words.t(model.string < 0 ? "openMotion" : "open");
    $("open").addEventListener("click", () => $("file").click());
    $("file").addEventListener("change", () => openRecords([...$("file").files]));
    document.addEventListener("dragover", (e) => e.preventDefault());
    document.addEventListener("drop", (e) => {
      e.preventDefault();
      if (e.dataTransfer.files.length > 0) openRecords([...e.dataTransfer.files]);
    });
  }

  /* recording starts again */
  function record() {
    if (paused) pause(false);
    replay.begin();
    replay.note();
    since = 0;
  }

  /* ---- playing ---- */

  function press(i, on, force = touch) {
    if (held[i] === on && !on) return;
    if (on && !soundChosen) sound(true);
    if (on && !held[i]) {
      if (!strokes.isOpen() || engine.armed()) {
        strokes.begin();
        record();
      }
      if (paused) pause(false);
      moved();
    }
    held[i] = on;
    engine.push(i, on ? force : 0, touch / 0.008);
    for (const b of document.querySelectorAll(`[data-input="${i}"]`)) b.setAttribute("aria-pressed", on);
    wake();
  }

  function dropLoad() {
    const on = !engine.loadPresent();
    if (on && !soundChosen) sound(true);
    if (on) strokes.begin();
    engine.load(on);
    if (on) record();
    else if (paused) pause(false);
    $("load").setAttribute("aria-pressed", on);
    $("load-words").textContent = on ? Words.t("takeLoad") : letGo();
    moved();
    wake();
  }
  function letGo() {
    const mass = geometry.num(model.bodies.find((b) => b.load).mass);
    return Words.t(scene.action ? "letGoKey" : "letGo", Format.quantity(mass, "kg"));
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
    record();
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
      const words = scene.action ? Words.t("pressKey") : Words.t("push", Words.of(input.name.replace(/_/g, " ")));
      holdButton(addButton(words, n === 0 ? Words.t("space") : "", "main"), input.i);
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
      const name = e.key.toLowerCase(); // with or without Caps Lock
      if (name === " " && first && !e.target.closest("button")) { // a slider has no use for it
        if (!e.repeat) press(first.i, true);
        e.preventDefault();
      } else if (name === "l" && hasLoad() && !e.repeat) dropLoad();
      else if (name === "r" && !e.repeat) again();
      else if (name === "p" && !e.repeat) pause(!paused);
      else if (name === ".") oneStep();
      else if (name === "?") Texts.openHelp(model, engine);
    });
    document.addEventListener("keyup", (e) => {
      if (e.key === " " && first && held[first.i]) press(first.i, false);
    });
    window.addEventListener("blur", () => held.forEach((h, i) => { if (h) press(i, false); }));
  }

  /* ---- dials ---- */

  function buildDials() {
    const abouts = new Map(model.abouts.map((a) => [a.entry, a.text]));
    for (const d of model.dials) {
      const starts = /(^|\.)initial\./.test(d.name); // where it begins: nothing to turn on the way
      const slider = Slider.add($("dials"), {
        ...d, label: starts ? Words.t("restarts", Words.of(d.label)) : Words.of(d.label), value: model.values[d.param], present: engine.value(d.param),
        about: abouts.get(d.name),
        turn(v) {
          const own = Math.abs(v - model.values[d.param]) < 1e-3 * (d.to - d.from);
          Address.put(d.name, own ? null : v);
          engine.aim(d.param, v, starts ? 0 : (d.to - d.from) / turnTime);
          if (starts) again();
          if (!plays()) moved();
          wake();
        },
      });
      d.take = slider.take;
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
    const slider = Slider.add($("dials"), {
      label: Words.t(scene.action ? "finger" : "pushing"), unit: first.unit, from: 0.1 * touch, to: 5 * touch,
      value: touch, present: touch, turn(v) { touch = v; slider.show(v); },
    });
    slider.show(touch);
  }

  /* ---- speed, sound, help, looks ---- */

  function buildSpeed() {
    // 0 .. 100: from a five-hundredth to real time; round numbers on the way
    const factor = (s) => 500 ** (s / 100 - 1);
    const words = (f) => (f > 0.995 ? Words.t("realTime") : Words.t("slower", Number((1 / f).toPrecision(2))));
    const turn = () => {
      const f = factor(+$("speed").value);
      speed = f > 0.995 ? 1 : 1 / Number((1 / f).toPrecision(2));
      $("speed-shown").textContent = words(speed);
      $("speed").setAttribute("aria-valuetext", words(speed));
    };
    const wish = Math.min(1, model.until / 6); // the file's own run in six seconds
    const usual = Math.round(100 * (1 + Math.log(wish) / Math.log(500)));
    $("speed").value = Address.number("speed", 0, 100) ?? usual;
    $("speed").addEventListener("input", () => {
      turn();
      Address.put("speed", +$("speed").value === usual ? null : +$("speed").value);
    });
    turn();
  }

  /* the direction to look from, of a mechanism that has a depth */
  function buildView({ view, spatial }) {
    const s = $("view"), wish = Address.get("view");
    $("view-choice").hidden = !spatial;
    if (!spatial) return;
    const take = (name) => { scene.look(name); s.value = name; };
    for (const name of geometry.views) s.append(new Option(Words.t(name), name));
    take(geometry.views.includes(wish) ? wish : view);
    s.addEventListener("change", () => {
      take(s.value);
      Address.put("view", s.value === view ? null : s.value);
      fit();
    });
  }

  function sound(on) {
    soundChosen = true;
    Sound.turn(on).then(() => {
      $("sound").setAttribute("aria-pressed", on);
      $("sound").textContent = Words.t(on ? "soundOn" : "soundOff");
    });
  }
  function buildSound() {
    $("sound").hidden = model.string < 0;
    soundChosen = model.string < 0 || Address.get("sound") === "off";
    $("sound").addEventListener("click", () => {
      const on = $("sound").getAttribute("aria-pressed") !== "true";
      sound(on);
      Address.put("sound", on ? null : "off");
    });
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

  /* numbers of the address: the mechanism starts with them; without them, should they be impossible */
  function takeAddress() {
    const given = model.dials.map((d) => Address.number(d.name, d.from, d.to));
    model.dials.forEach((d, i) => { if (given[i] !== null) engine.aim(d.param, given[i], 0); });
    try {
      engine.reset();
    } catch (error) {
      model.dials.forEach((d) => { engine.aim(d.param, model.values[d.param], 0); Address.put(d.name, null); });
      engine.reset();
    }
    for (const d of model.dials) geometry.params[d.param] = engine.value(d.param);
  }

  /* a link with other settings was followed while the page is open */
  function followAddress() {
    for (const d of model.dials) d.take(Address.number(d.name, d.from, d.to) ?? model.values[d.param]);
    if (Address.get("lang") && Words.languages.indexOf(Address.get("lang")) >= 0 &&
        Address.get("lang") !== document.documentElement.lang) location.reload();
  }

  async function start() {
    Texts.chooseLanguage();
    const every = Math.max(1, Math.round(model.until / model.dt / 2000));
    engine = await Engine.create($("module").textContent, model, every);
    geometry = Geometry.create(model);
    replay = Replay.create(engine);
    scene = Scene.create($("stage"), geometry);
    traces = Traces.create($("traces"), model, $("legend"));
    $("traces").parentElement.hidden = traces.empty;
    const dx = model.dials.find((d) => d.name === "pawl.stop_shift");
    $("strokes").hidden = model.string < 0;
    $("chart-section").hidden = !dx || model.string < 0;
    strokes = Strokes.create({ engine, table: $("table"), chart: $("chart"),
                               dial: dx ? dx.param : null, say: (t) => { $("announce").textContent = t; } });
    if (model.string < 0) strokes.begin = strokes.follow = strokes.forget = () => {};
    takeAddress();
    const seenFrom = Preview.run({ model, engine, geometry, scene, traces });
    startState();
    Texts.titles(model);
    buildActions();
    buildStage();
    buildKeys();
    buildDials();
    buildSpeed();
    buildView(seenFrom);
    buildReplay();
    buildMeasured();
    buildTour(dx);
    buildSound();
    const keys = [forceInputs().length > 0 && Words.t("keySpace"), hasLoad() && Words.t("keyLoad"),
                  Words.t("keyAgain"), Words.t("keyPause"), Words.t("keyTab")];
    Texts.buildHelp(model, engine, scene.action, keys);
    theme();
    fit();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { theme(); show(); });
    window.addEventListener("resize", fit);
    window.addEventListener("hashchange", followAddress);
    asleep = plays() && model.settle === 1; // else it moves by itself
    if (!plays()) moved();
    record();
    show();
    document.documentElement.dataset.ready = "yes";
    requestAnimationFrame((now) => { last = now; frame(now); });
  }

  start().catch((error) => {
    document.documentElement.dataset.ready = "failed";
    fail(error);
  });

  return { engine: () => engine, strokes: () => strokes, perFrame, geometry: () => geometry,
           scene: () => scene, replay: () => replay, tour: () => tour, paused: () => paused };
})();
