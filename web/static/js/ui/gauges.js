// The ring that counts down to the next snapshot, and the run's counters.

import { build } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
const RADIUS = 44;
const AROUND = 2 * Math.PI * RADIUS;
/** A new snapshot's number of pairs stays to be seen for so long. */
const GAIN_MS = 1500;

/** @param {Document} document @param {Record<string, string>} attributes */
function circle(document, attributes) {
  const element = document.createElementNS(SVG, "circle");
  for (const [name, value] of Object.entries({ cx: "50", cy: "50", r: String(RADIUS), ...attributes })) element.setAttribute(name, value);
  return element;
}

/** @param {number} value */
const grouped = (value) => value.toLocaleString("en-GB").replaceAll(",", "\u202f");

/** @typedef {{ seconds: number, share: number, reason: string, still: boolean }} RingLook reason: why there is no snapshot to wait for */
/** @typedef {{ pairs: number, pairsTotal: number, iteration: number, iterations: number, inIteration: number, perIteration: number, beta: number, byExpert: number, agents: number, isLead: boolean }} Counts isLead: the expert in question is who looks at this page */

/** Ring and counters. */
export class Gauges {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    const document = parent.ownerDocument;
    this.document = document;
    this.arc = circle(document, { class: "ring-left", "stroke-dasharray": String(AROUND), transform: "rotate(-90 50 50)" });
    const picture = document.createElementNS(SVG, "svg");
    picture.setAttribute("viewBox", "0 0 100 100");
    picture.setAttribute("aria-hidden", "true");
    picture.append(circle(document, { class: "ring-whole" }), this.arc);
    this.seconds = build(document, "span", { class: "ring-seconds" }, "–");
    this.gain = build(document, "span", { class: "ring-gain", "aria-hidden": "true" });
    this.caption = build(document, "p", { class: "ring-caption" }, "to the next snapshot");
    this.ring = build(document, "div", { class: "ring", role: "timer", "aria-label": "Seconds to the next snapshot" }, picture, this.seconds, this.gain);
    this.values = /** @type {Record<string, HTMLElement>} */ ({});
    this.labels = /** @type {Record<string, HTMLElement>} */ ({});
    this.bar = build(document, "span", {});
    const counter = (/** @type {string} */ name, /** @type {string} */ label, /** @type {Node[]} */ ...more) => {
      const value = (this.values[name] = build(document, "dd", {}, "–"));
      const text = (this.labels[name] = build(document, "dt", {}, label));
      return build(document, "div", { class: "counter", "data-name": name }, text, value, ...more);
    };
    const bar = build(document, "dd", { class: "within", "aria-hidden": "true" }, this.bar);
    const counters = build(
      document, "dl", { class: "counters" },
      counter("iteration", "Iteration", bar), counter("pairs", "Pairs"), counter("beta", "β"), counter("own", "Agents"),
    );
    parent.append(build(document, "div", { class: "ring-place" }, this.ring, this.caption), counters);
    this.pairs = NaN;
    this.gainUntil_ms = 0;
  }

  /** @param {RingLook} look */
  showRing({ seconds, share, reason, still }) {
    const waits = reason !== "";
    this.ring.classList.toggle("idle", waits);
    this.arc.setAttribute("stroke-dashoffset", String(AROUND * (1 - (waits ? 0 : still ? Math.ceil(seconds) / 4 : share))));
    this.#write(this.seconds, waits ? "‖" : still ? String(Math.ceil(seconds)) : seconds.toFixed(1));
    this.#write(this.caption, waits ? reason : "s to the next snapshot");
  }

  /** @param {Counts} counts @param {number} now_ms */
  showCounts(counts, now_ms) {
    const { values } = this;
    if (counts.pairs > this.pairs) {
      this.#write(this.gain, `+${counts.pairs - this.pairs}`);
      this.gainUntil_ms = now_ms + GAIN_MS;
    }
    this.pairs = counts.pairs;
    this.#write(values.pairs, `${grouped(counts.pairs)} of ${grouped(counts.pairsTotal)}`);
    this.#write(values.iteration, `${counts.iteration} of ${counts.iterations}`);
    this.#write(values.beta, counts.beta.toFixed(3));
    this.#write(values.own, `${counts.byExpert} of ${counts.agents}`);
    this.#write(this.labels.beta, counts.isLead ? "β, share of your settings" : "β, share of lead's settings");
    this.#write(this.labels.own, counts.isLead ? "Agents that show yours" : "Agents that show the lead's");
    this.bar.style.transform = `scaleX(${counts.perIteration ? counts.inIteration / counts.perIteration : 0})`;
  }

  /** Lets the last gain fade. @param {number} now_ms */
  tick(now_ms) {
    this.gain.classList.toggle("seen", now_ms < this.gainUntil_ms && !this.ring.classList.contains("idle"));
  }

  /** @param {HTMLElement | undefined} element @param {string} text */
  #write(element, text) {
    if (element && element.textContent !== text) element.textContent = text;
  }
}
