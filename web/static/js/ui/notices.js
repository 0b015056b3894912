// What must be said over the picture: a lost line, the end of the run, the outcome of a key.

import { build } from "./dom.js";

const TOAST_MS = 1600;
const REFUSAL_MS = 6000;

/** One banner for states that last, one line for what just happened. */
export class Notices {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    this.document = parent.ownerDocument;
    this.banner = build(this.document, "div", { class: "banner", role: "alert" });
    this.banner.hidden = true;
    this.toast = build(this.document, "p", { class: "toast", role: "status" });
    this.note = build(this.document, "div", { class: "note" });
    this.note.hidden = true;
    parent.append(this.banner, this.note, this.toast);
    this.shown = "";
    this.toastUntil_ms = 0;
  }

  /** @param {string} kind @param {string} title @param {string[]} lines @param {{ text: string, address: string }[]} [links] */
  showBanner(kind, title, lines, links = []) {
    const key = `${kind} ${title} ${lines.join(" ")}`;
    if (key === this.shown) return;
    this.shown = key;
    this.banner.dataset.kind = kind;
    this.banner.replaceChildren(
      build(this.document, "h2", {}, title),
      ...lines.map((line) => build(this.document, "p", {}, line)),
      ...links.map(({ text, address }) => build(this.document, "a", { class: "button", href: address }, text)),
    );
    this.banner.hidden = false;
  }

  hideBanner() {
    this.shown = "";
    this.banner.hidden = true;
  }

  /** A quiet note in the middle of the picture. @param {string} text empty for none */
  showNote(text) {
    if (this.note.textContent !== text) this.note.textContent = text;
    this.note.hidden = text === "";
  }

  /** @param {string} text @param {boolean} [isRefusal] @param {number} [shown_ms] */
  say(text, isRefusal = false, shown_ms = isRefusal ? REFUSAL_MS : TOAST_MS) {
    this.toast.textContent = text;
    this.toast.classList.toggle("refusal", isRefusal);
    this.toast.classList.add("seen");
    this.toastUntil_ms = performance.now() + shown_ms;
  }

  /** @param {number} now_ms */
  tick(now_ms) {
    if (now_ms > this.toastUntil_ms) this.toast.classList.remove("seen");
  }
}
