// The quiet line at the upper edge: which display, boxes delivered, time, connection. It says nothing
// about the robots.

import { build } from "./dom.js";

/** Round trips longer than this are called slow. */
const SLOW_MS = 250;

/** @param {number} seconds @returns {string} minutes:seconds */
export function formatTime(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return `${String(Math.floor(whole / 60)).padStart(2, "0")}:${String(whole % 60).padStart(2, "0")}`;
}

/** Facts about the trial. */
export class Hud {
  /** @param {HTMLElement} parent @param {() => void} askHelp */
  constructor(parent, askHelp) {
    const document = parent.ownerDocument;
    this.label = build(document, "span", { class: "hud-value" });
    this.boxes = build(document, "span", { class: "hud-value" });
    this.fill = build(document, "span", {});
    this.time = build(document, "span", { class: "hud-value" }, "00:00");
    this.line = build(document, "span", { class: "hud-line", "data-quality": "good" });
    this.lineText = build(document, "span", { class: "visually-hidden" }, "Connected");
    const item = (/** @type {string} */ name, /** @type {Node[]} */ ...parts) =>
      build(document, "div", { class: "hud-item", "data-name": name }, ...parts);
    const named = (/** @type {string} */ text) => build(document, "span", { class: "hud-name" }, text);
    this.root = build(
      document, "div", { class: "hud", role: "group", "aria-label": "This round" },
      item("label", this.label),
      item("boxes", named("Boxes"), this.boxes, build(document, "div", { class: "hud-bar", "aria-hidden": "true" }, this.fill)),
      item("time", named("Time"), this.time),
      item("line", this.line, this.lineText),
    );
    this.root.hidden = true;
    this.help = build(document, "button", { class: "help-button", type: "button", "aria-label": "Help (H)", title: "Help (H)" }, "?");
    this.help.addEventListener("click", askHelp);
    this.heading = build(document, "h1", { class: "visually-hidden" }, "The warehouse");
    parent.append(this.heading, this.root, this.help);
    this.shownSecond = -1;
    this.shownQuality = "good";
  }

  /** @param {string} label @param {number} total boxes of the trial */
  begin(label, total) {
    this.label.textContent = label;
    this.heading.textContent = `${label}: the warehouse`;
    this.total = total;
    this.root.hidden = false;
  }

  /** @param {number} delivered */
  showBoxes(delivered) {
    const total = this.total ?? 0;
    this.boxes.textContent = `${delivered} of ${total}`;
    this.fill.style.transform = `scaleX(${total ? delivered / total : 0})`;
  }

  /** @param {number} seconds of the trial */
  showTime(seconds) {
    const second = Math.floor(seconds);
    if (second === this.shownSecond) return;
    this.shownSecond = second;
    this.time.textContent = formatTime(seconds);
  }

  /** @param {boolean} open @param {number} roundTrip_ms NaN when not yet known */
  showLine(open, roundTrip_ms) {
    const quality = !open ? "lost" : roundTrip_ms > SLOW_MS ? "slow" : "good";
    if (quality === this.shownQuality) return;
    this.shownQuality = quality;
    this.line.dataset.quality = quality;
    this.lineText.textContent = { lost: "Not connected", slow: "Slow connection", good: "Connected" }[quality];
  }
}
