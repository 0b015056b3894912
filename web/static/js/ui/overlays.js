// Notes, countdown and help over the view. One of them is seen at a time; help lies above the rest.

import { build } from "./dom.js";
import { CONTROLS, NOTES } from "./notes.js";

/** Shows what keeps the participant from playing, and why. */
export class Overlays {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    this.document = parent.ownerDocument;
    this.kind = "";
    this.root = build(this.document, "div", { class: "overlay", "aria-live": "polite" });
    this.root.hidden = true;
    this.count = build(this.document, "div", { class: "count" });
    this.helpRoot = this.#buildHelp();
    this.hint = build(this.document, "div", { class: "hint" }, "Click into the picture to look around with the mouse");
    this.hint.hidden = true;
    parent.append(this.root, this.hint, this.helpRoot);
  }

  /** @param {string} kind of NOTES */
  show(kind) {
    if (this.kind === kind) return;
    this.kind = kind;
    const note = NOTES[kind] ?? { title: kind, lines: [] };
    const box = build(this.document, "div", { class: "note" });
    if (note.busy) box.append(build(this.document, "div", { class: "spinner", "aria-hidden": "true" }));
    box.append(build(this.document, "h2", {}, note.title), ...note.lines.map((line) => build(this.document, "p", {}, line)));
    this.root.dataset.kind = kind;
    this.root.replaceChildren(box);
    this.root.hidden = false;
  }

  /** @param {number} seconds left */
  showCountdown(seconds) {
    const text = String(Math.max(1, Math.ceil(seconds)));
    if (this.kind !== "countdown") {
      this.kind = "countdown";
      this.root.dataset.kind = "countdown";
      this.root.replaceChildren(this.count);
      this.root.hidden = false;
    }
    if (this.count.textContent !== text) this.count.textContent = text;
  }

  hide() {
    this.kind = "";
    this.root.hidden = true;
  }

  /** @param {boolean} shown */
  showHint(shown) {
    this.hint.hidden = !shown;
  }

  /** Says in the hint how to look around where the browser refuses to lend the mouse. */
  explainTurning() {
    this.hint.textContent = "This browser keeps the mouse to itself: turn with the keys Q and E";
  }

  get isHelpOpen() {
    return !this.helpRoot.hidden;
  }

  toggleHelp() {
    this.helpRoot.hidden = !this.helpRoot.hidden;
    if (this.isHelpOpen) this.helpRoot.querySelector("button")?.focus();
    else if (this.document.activeElement instanceof HTMLElement) this.document.activeElement.blur();
  }

  #buildHelp() {
    const { document } = this;
    const list = build(document, "dl", { class: "keys" });
    for (const { keys, text } of CONTROLS)
      list.append(build(document, "dt", {}, ...keys.map((key) => build(document, "kbd", {}, key))), build(document, "dd", {}, text));
    const close = build(document, "button", { class: "button", type: "button" }, "Back to the warehouse");
    close.addEventListener("click", () => this.toggleHelp());
    const box = build(
      document, "div", { class: "note" },
      build(document, "h2", { id: "help-title" }, "How to move"), list,
      build(document, "p", {}, "A robot that stands in its bay with a box is unloaded when you come within one metre of it. The robots go on working while you read this."),
      ...this.#withdrawal(), close,
    );
    const root = build(document, "div", { class: "overlay", "data-kind": "help", role: "dialog", "aria-modal": "true", "aria-labelledby": "help-title" }, box);
    root.hidden = true;
    return root;
  }

  /** The page's own withdrawal link, offered in the help as well. */
  #withdrawal() {
    const link = this.document.querySelector("a#withdraw");
    if (!(link instanceof HTMLAnchorElement)) return [];
    const copy = build(this.document, "a", { href: link.getAttribute("href") ?? "" }, link.textContent ?? "Withdraw");
    return [build(this.document, "p", {}, copy)];
  }
}
