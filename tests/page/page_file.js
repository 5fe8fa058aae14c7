/* SPDX-License-Identifier: MIT
 * page_file.js - a written page taken apart, and a count of claims. */
"use strict";

const fs = require("fs");
const vm = require("vm");

/* its text, mechanism, module, and the scripts that need no browser, ready to be called */
function read(file) {
  const html = fs.readFileSync(file, "utf8");
  const part = (id) => html.match(new RegExp(`<script[^>]* id="${id}">\n([^]*?)</script>`))[1];
  const context = vm.createContext({ WebAssembly, TextDecoder, atob, Math, console });
  const code = part("code");
  vm.runInContext(code.slice(0, code.indexOf("const Page = ")) +
                  ";var page = { Format, Words, Replay, Measured, Engine, Geometry, Traces, Strokes, Sound };", context);
  return { html, model: JSON.parse(part("model")), module: part("module"), ...context.page };
}

/* what a dial of the page turns at: main.js's turnTime */
const paceOf = (html, dial) => (dial.to - dial.from) / Number(html.match(/const turnTime = ([\d.]+)/)[1]);

const count = { passed: 0, failed: 0 };
function claim(text, truth, shown) {
  if (truth) count.passed++;
  else {
    count.failed++;
    console.log(`FAILED: ${text}${shown === undefined ? "" : `: ${shown}`}`);
  }
}

module.exports = { read, paceOf, claim, count };
