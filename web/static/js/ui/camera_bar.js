// The choice of cameras over the picture.

import { build } from "./dom.js";

const NAMES = /** @type {Record<string, string>} */ ({ worker: "Worker's eyes", above: "From above", free: "Free" });
const HINTS = /** @type {Record<string, string>} */ ({
  worker: "As the worker sees it",
  above: "Drag moves, wheel zooms, click picks",
  free: "Drag turns, Shift moves, wheel zooms",
});

/** Buttons for the cameras. */
export class CameraBar {
  /** @param {HTMLElement} parent @param {readonly string[]} modes @param {{ choose: (mode: string) => void, refit: () => void, numbers: () => void }} handlers @param {Record<string, string>} [hints] that differ on this page */
  constructor(parent, modes, handlers, hints = {}) {
    const document = parent.ownerDocument;
    /** @type {Record<string, string>} */
    this.hints = { ...HINTS, ...hints };
    this.buttons = modes.map((mode) => {
      const button = build(document, "button", { type: "button", "data-mode": mode, title: this.hints[mode] ?? "" }, NAMES[mode] ?? mode);
      button.addEventListener("click", () => handlers.choose(mode));
      return button;
    });
    const refit = build(document, "button", { type: "button", title: "Show the whole hall again" }, "Whole hall ", build(document, "kbd", {}, "F"));
    refit.addEventListener("click", handlers.refit);
    const numbers = build(document, "button", { type: "button", title: "Numbers on all robots, or only where the live location is displayed" }, "Numbers ", build(document, "kbd", {}, "N"));
    numbers.addEventListener("click", handlers.numbers);
    this.extras = [refit, numbers];
    this.hint = build(document, "p", { class: "camera-hint" });
    parent.append(
      build(document, "div", { class: "choice", role: "group", "aria-label": "Camera (V changes it)" }, ...this.buttons, build(document, "kbd", { "aria-hidden": "true" }, "V")),
      ...this.extras, this.hint,
    );
  }

  /** @param {string} mode */
  show(mode) {
    for (const button of this.buttons) button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    for (const extra of this.extras) extra.hidden = mode === "worker";
    this.hint.textContent = this.hints[mode] ?? "";
  }
}
