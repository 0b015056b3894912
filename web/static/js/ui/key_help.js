// The overlay that lists the keys.

import { build } from "./dom.js";

/** @type {readonly { title: string, keys: readonly [string[], string][] }[]} */
const GROUPS = Object.freeze([
  {
    title: "Choose a row",
    keys: [
      [["1", "…", "9"], "robot 1 to 9; two digits one after the other for 10 and more (0 alone is 10)"],
      [["S", "1", "…", "4"], "station 1 to 4: S, then its number"],
      [["↑", "↓"], "the row above or below"],
      [["←", "→"], "the cell to the left or right; Enter switches it"],
    ],
  },
  {
    title: "Set what the worker sees",
    keys: [
      [["T"], "trajectory of the chosen robot"],
      [["L"], "live location"],
      [["G"], "ghost avatar (transparent, along the planned path)"],
      [["B"], "balloon of the chosen station"],
      [["Space"], "the whole row: all off if all is on, else all on"],
      [["Shift", "T", "L", "G", "B"], "the whole column, likewise"],
    ],
  },
  {
    title: "Say and take back",
    keys: [
      [["R"], "this row is right as it is"],
      [["Shift", "R"], "every row is right"],
      [["U"], "take back your last change; also Ctrl+Z"],
    ],
  },
  {
    title: "Look",
    keys: [
      [["V"], "next camera: worker's eyes, from above, free"],
      [["W", "A", "S", "D"], "move the camera from above or free"],
      [["Q", "E"], "turn the free camera"],
      [["+", "−"], "zoom; the wheel does the same"],
      [["F", "N"], "whole hall again; numbers on all robots"],
      [["?", "H"], "this help; Esc closes it"],
    ],
  },
]);

/** A dialog with all keys. */
export class KeyHelp {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    const document = parent.ownerDocument;
    const groups = GROUPS.map(({ title, keys }) =>
      build(
        document, "section", {}, build(document, "h3", {}, title),
        build(document, "dl", { class: "keys" }, ...keys.flatMap(([caps, text]) => [
          build(document, "dt", {}, ...caps.map((cap) => (cap === "…" ? cap : build(document, "kbd", {}, cap)))),
          build(document, "dd", {}, text),
        ])),
      ));
    const close = build(document, "button", { type: "button", class: "button" }, "Back to the run");
    close.addEventListener("click", () => this.toggle());
    this.dialog = build(
      document, "dialog", { class: "help", "aria-labelledby": "help-title" },
      build(document, "h2", { id: "help-title" }, "Keys"),
      build(document, "p", {}, "They work wherever the focus is, except while you type into a field. The world goes on while you read this."),
      build(document, "div", { class: "help-groups" }, ...groups), close,
    );
    parent.append(this.dialog);
  }

  get isOpen() {
    return this.dialog.open;
  }

  toggle() {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }
}
