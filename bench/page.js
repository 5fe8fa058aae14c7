/* SPDX-License-Identifier: MIT
 * page.js - cost of a frame of a page: the module in nodejs, as in a browser of the same family.
 *
 *   node bench/page.js PAGE.html */
"use strict";

const fs = require("fs");
const { read } = require("../tests/page/page_file.js");

const file = process.argv[2], page = read(file), { model } = page;
const steps = Math.round(1 / 60 / model.dt), frames = Math.round(model.until * 60);

async function run() {
  const engine = await page.Engine.create(page.module, model, 12), cost = [];
  for (let n = 0; n < 20; n++) {
    engine.reset();
    for (let k = 0; k < frames; k++) {
      const t0 = process.hrtime.bigint();
      engine.advance(steps);
      cost.push(Number(process.hrtime.bigint() - t0) / 1e6);
    }
  }
  cost.sort((a, b) => a - b);
  const at = (share) => cost[Math.floor(share * (cost.length - 1))].toFixed(2);
  const kilobytes = (n) => Math.round(n / 1000);
  console.log(`page of ${model.name}: ${kilobytes(fs.statSync(file).size)} KB, module ` +
    `${kilobytes(page.module.length * 3 / 4)} KB; ${steps} steps, a frame of real time: ` +
    `${at(0)} ms at least, median ${at(0.5)}, 99 % below ${at(0.99)}`);
}

run();
