/* SPDX-License-Identifier: MIT
 * browser.js - a headless Chromium driven over a pipe (DevTools protocol, one JSON text and a zero
 * byte a message). No packages beside Debian's chromium and nodejs. */
"use strict";

const { spawn } = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");

const flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
  "--disable-default-apps", "--mute-audio", "--hide-scrollbars", "--disable-dev-shm-usage",
  "--autoplay-policy=no-user-gesture-required", "--remote-debugging-pipe"];

/* A browser with one page. call(method, params) speaks the protocol to the page. */
async function open(program) {
  const home = fs.mkdtempSync(path.join(os.tmpdir(), "stein-browser-"));
  const child = spawn(program, [...flags, `--user-data-dir=${home}`, "about:blank"],
    { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"], env: { ...process.env, HOME: home } });
  const waiting = new Map(), listeners = [];
  let next = 1, rest = "", session;
  child.stdio[4].on("data", (data) => {
    const parts = (rest + data).split("\0");
    rest = parts.pop();
    for (const part of parts) {
      const m = JSON.parse(part), w = waiting.get(m.id);
      if (w) {
        waiting.delete(m.id);
        if (m.error) w.reject(new Error(m.error.message));
        else w.resolve(m.result);
      } else for (const l of listeners) l(m.method, m.params);
    }
  });
  const gone = new Promise((resolve) => child.on("exit", resolve));
  gone.then(() => { for (const w of waiting.values()) w.reject(new Error("the browser ended")); });
  child.on("error", (e) => { for (const w of waiting.values()) w.reject(e); });
  const send = (method, params = {}, sessionId) => new Promise((resolve, reject) => {
    waiting.set(next, { resolve, reject });
    child.stdio[3].write(JSON.stringify({ id: next++, method, params, sessionId }) + "\0");
  });
  const { targetInfos } = await send("Target.getTargets");
  const page = targetInfos.find((t) => t.type === "page");
  session = (await send("Target.attachToTarget", { targetId: page.targetId, flatten: true })).sessionId;
  const call = (method, params) => send(method, params, session);
  await call("Page.enable");
  await call("Runtime.enable");
  await call("Network.enable");

  async function evaluate(expression) {
    const r = await call("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (r.exceptionDetails)
      throw new Error(r.exceptionDetails.exception?.description || r.exceptionDetails.text);
    return r.result.value;
  }
  /* until the expression is true; while a page is loaded again nothing is */
  async function until(expression, ms = 20000) {
    const end = Date.now() + ms;
    const holds = () => evaluate(expression).catch((e) => {
      if (/navigated|context/.test(e.message)) return false;
      throw e;
    });
    while (!(await holds())) {
      if (Date.now() > end) throw new Error(`never true: ${expression}`);
      await new Promise((resolve) => setTimeout(resolve, 30));
    }
  }
  /* virtual: the number of a key that the browser itself acts on, Tab 9, Escape 27 */
  async function key(type, name, code, virtual, shift) {
    await call("Input.dispatchKeyEvent", { type, key: name, code, windowsVirtualKeyCode: virtual, modifiers: shift ? 8 : 0,
                                           text: type === "keyDown" && name.length === 1 ? name : undefined });
  }
  async function mouse(type, [x, y]) {
    await call("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons: type === "mousePressed" ? 1 : 0, clickCount: 1 });
  }
  async function close() {
    send("Browser.close").catch(() => {});
    await gone;
    fs.rmSync(home, { recursive: true, force: true, maxRetries: 5 });
  }
  return { call, evaluate, until, key, mouse, close, on: (l) => listeners.push(l) };
}

module.exports = { open };
