/* SPDX-License-Identifier: MIT
 * texts.js - the texts around the drawing: heading, language, help. */
"use strict";

const Texts = (() => {
  const $ = (id) => document.getElementById(id);

  function titles(model) {
    const about = (model.abouts.find((a) => a.section === "") || { text: model.name }).text;
    const cut = about.indexOf(" - "), first = Words.of(cut < 0 ? about : about.slice(0, cut));
    $("title").textContent = first[0].toUpperCase() + first.slice(1).replace(/\.$/, "");
    $("subtitle").textContent = cut < 0 ? "" : Words.of(about.slice(cut + 3));
    document.title = $("title").textContent;
    $("foot").textContent = Words.t("foot", model.version, model.name, model.equations, Format.quantity(model.dt, "s"));
  }

  /* the language of the address, else of the browser; another one is another page of the same settings */
  function chooseLanguage() {
    const code = Words.choose(Address.get("lang") || navigator.language);
    document.documentElement.lang = code;
    Words.write(document);
    Words.languages.forEach((c, i) => $("language").append(new Option(Words.names[i], c, c === code, c === code)));
    $("language").addEventListener("change", () => {
      Address.put("lang", $("language").value);
      location.reload();
    });
  }

  function openHelp(model, engine) {
    $("help").showModal();
    if ($("help-check").textContent) return;
    const here = engine.verify();
    $("help-check").textContent = here === model.hash
      ? Words.t("same", Format.quantity(model.until, "s"), here)
      : Words.t("other", Format.quantity(model.until, "s"), here, model.hash);
  }

  /* keys: words for those of this mechanism */
  function buildHelp(model, engine, shaped, keys) {
    $("help-action").hidden = !shaped;
    if (!shaped)
      for (const a of model.abouts) {
        if (a.section === "" || a.entry === "") continue;
        const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
        dt.textContent = a.entry.replace(/_/g, " ");
        dd.textContent = a.text;
        $("help-abouts").append(dt, dd);
      }
    $("help-keys").textContent = Words.t("keys") + keys.filter((k) => k).join(", ") + ".";
    $("help-open").addEventListener("click", () => openHelp(model, engine));
    $("help").addEventListener("click", (e) => { if (e.target === $("help")) $("help").close(); });
  }

  return { titles, chooseLanguage, openHelp, buildHelp };
})();
