// Entry of the browser check: finds out whether this device can show the warehouse and fills the form.

import { measureFrameRate, measureLatency, probeWebGl } from "./check/probes.js";
import { CheckList } from "./check/list.js";

const MOVE_CODES = ["KeyW", "KeyA", "KeyS", "KeyD", "ArrowUp", "ArrowLeft", "ArrowDown", "ArrowRight"];

/** @param {HTMLFormElement} form @param {string} name @param {string} value */
function fill(form, name, value) {
  const input = form.elements.namedItem(name);
  if (input instanceof HTMLInputElement) input.value = value;
}

/** @param {HTMLFormElement} form @param {CheckList} list */
function watchKeyboard(form, list) {
  const heard = (/** @type {KeyboardEvent} */ event) => {
    if (!MOVE_CODES.includes(event.code)) return;
    fill(form, "keyboard", "yes");
    list.settle("keyboard", true, "Keyboard: the keys work.");
    removeEventListener("keydown", heard);
  };
  addEventListener("keydown", heard);
}

/** @param {HTMLFormElement} form @param {CheckList} list */
function watchMouse(form, list) {
  const moved = (/** @type {PointerEvent} */ event) => {
    if (event.pointerType !== "mouse" && event.pointerType !== "pen") return;
    fill(form, "mouse", "yes");
    list.settle("mouse", true, "Mouse or trackpad: found.");
    removeEventListener("pointermove", moved);
  };
  addEventListener("pointermove", moved);
}

/** @param {HTMLFormElement} form @param {CheckList} list */
async function checkGraphics(form, list) {
  const canDraw = probeWebGl(document);
  fill(form, "webgl", canDraw ? "yes" : "no");
  if (!canDraw) {
    list.settle("webgl", false, "3D graphics: WebGL 2 is missing or switched off in this browser.");
    list.settle("frame_rate", false, "Frame rate: not measured.");
    return;
  }
  list.settle("webgl", true, "3D graphics: available.");
  const rate = await measureFrameRate(window);
  fill(form, "frame_rate_hz", rate.toFixed(1));
  const verdict = rate >= 25 ? "" : " That is slow; closing other programs and tabs may help.";
  list.settle("frame_rate", true, `Frame rate: ${Math.round(rate)} pictures per second.${verdict}`);
}

/** @param {HTMLFormElement} form @param {CheckList} list */
async function checkConnection(form, list) {
  const latency_ms = await measureLatency(form.dataset.ping ?? "/healthz", 5);
  if (latency_ms === null) {
    list.settle("latency", true, "Connection: could not be measured; you can go on.");
    return;
  }
  fill(form, "latency_ms", latency_ms.toFixed(1));
  list.settle("latency", true, `Connection: answers in ${Math.round(latency_ms)} milliseconds.`);
}

/** @param {HTMLFormElement} form @param {HTMLElement} results */
async function runChecks(form, results) {
  const list = new CheckList(results, {
    keyboard: "Keyboard: please press one of the keys W, A, S or D.",
    mouse: "Mouse: please move it over this page.",
    webgl: "3D graphics: checking.",
    frame_rate: "Frame rate: measuring.",
    latency: "Connection: measuring.",
  });
  const touchOnly = navigator.maxTouchPoints > 0 && !matchMedia("(any-pointer: fine)").matches;
  fill(form, "touch_only", touchOnly ? "yes" : "no");
  fill(form, "keyboard", "no");
  fill(form, "mouse", "no");
  if (touchOnly) list.settle("mouse", false, "This device seems to have only a touch screen.");
  watchKeyboard(form, list);
  watchMouse(form, list);
  await checkGraphics(form, list);
  await checkConnection(form, list);
}

const form = document.getElementById("check");
const results = document.getElementById("check-results");
if (form instanceof HTMLFormElement && results) void runChecks(form, results);
