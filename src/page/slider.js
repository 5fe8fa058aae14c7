/* SPDX-License-Identifier: MIT
 * slider.js - a number that is turned: its name, value, way back to the file's value, and a mark
 * where the number is while it moves. */
"use strict";

const Slider = (() => {
  function add(list, { label, about, unit, from, to, value, present, turn }) {
    const row = document.createElement("div"), id = "dial" + list.children.length;
    row.className = "dial";
    row.innerHTML = `<label for="${id}"></label><output for="${id}"></output>` +
      `<button type="button">${Words.t("reset")}</button><div class="range"><input id="${id}" type="range" min="0" ` +
      `max="1000" step="1"><i class="now"></i></div>`;
    const [input, output, now] = ["input", "output", ".now"].map((s) => row.querySelector(s));
    row.querySelector("label").textContent = label;
    row.querySelector("button").setAttribute("aria-label", Words.t("resetOf", label));
    if (about) row.title = about;
    const at = (v) => 1000 * (v - from) / (to - from);
    const put = (v) => {
      output.textContent = Format.quantity(v, unit);
      input.setAttribute("aria-valuetext", output.textContent);
      row.classList.toggle("turned", Math.abs(v - value) > 1e-3 * (to - from));
    };
    input.value = at(present);
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
    put(present);
    list.append(row);
    return { take(v) { input.value = at(v); put(v); turn(v); },
             show(v) { now.style.left = `calc(0.5rem + (100% - 1rem) * ${at(v) / 1000})`; } };
  }

  return { add };
})();
