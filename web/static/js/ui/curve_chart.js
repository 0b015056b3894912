// The discrepancies over the iterations as lines, drawn from stored pairs.

import uPlot from "uplot";
import { build } from "./dom.js";

/** @typedef {{ name: string, label: string, help: string, share: boolean }} Measure */
/** @typedef {{ name: string, label: string }} NamedLine */
/**
 * @typedef {object} Source of the values
 * @property {(measure: string) => NamedLine[]} named lines there are
 * @property {(measure: string, names: string[]) => (number | null)[][]} table
 */

/** Colour and dashes: no two lines differ by colour alone. */
const STYLES = /** @type {Record<string, { stroke: string, dash: number[], width: number }>} */ ({
  policy: { stroke: "#6cc8ff", dash: [], width: 2.5 },
  arroch: { stroke: "#ffb454", dash: [8, 4], width: 1.75 },
  all_off: { stroke: "#b9c5ce", dash: [2, 3], width: 1.5 },
  majority: { stroke: "#d9a6ff", dash: [10, 3, 2, 3], width: 1.5 },
  floor: { stroke: "#7fe0a6", dash: [4, 2], width: 1.5 },
});
const INK = "#b9c5ce";
const GRID = "rgba(255, 255, 255, 0.09)";
const FONT = "12px system-ui, 'Segoe UI', 'DejaVu Sans', Arial, sans-serif";

/** A chart with a choice of measures and of lines. */
export class CurveChart {
  /** @param {HTMLElement} parent @param {readonly Measure[]} measures @param {Source} source */
  constructor(parent, measures, source) {
    const document = parent.ownerDocument;
    this.document = document;
    this.measures = measures;
    this.source = source;
    this.measure = /** @type {Measure} */ (measures[0]);
    /** @type {Set<string>} lines switched off */
    this.hidden = new Set(["all_off"]);
    /** @type {uPlot | null} */
    this.plot = null;
    this.drawn = "";
    this.choice = build(document, "div", { class: "choice", role: "group", "aria-label": "Measure" }, ...measures.map((measure) => this.#buildChoice(measure)));
    this.chips = build(document, "div", { class: "chips", role: "group", "aria-label": "Lines" });
    this.place = build(document, "div", { class: "chart", role: "img" });
    this.empty = build(document, "p", { class: "empty" }, "The first point appears when the pairs of the first iteration are stored.");
    parent.append(build(document, "div", { class: "curves-head" }, build(document, "h2", {}, "Discrepancy"), this.choice, this.chips), this.empty, this.place);
    new ResizeObserver(() => this.#resize()).observe(this.place);
    this.#showChoice();
  }

  /** @param {Measure} measure */
  #buildChoice(measure) {
    const button = build(this.document, "button", { type: "button", title: measure.help, "data-measure": measure.name }, measure.label);
    button.addEventListener("click", () => {
      this.measure = measure;
      this.#showChoice();
      this.update();
    });
    return button;
  }

  #showChoice() {
    for (const button of this.choice.querySelectorAll("button")) button.setAttribute("aria-pressed", String(button.dataset.measure === this.measure.name));
  }

  /** Draws what is known now. */
  update() {
    const named = this.source.named(this.measure.name);
    const names = named.map(({ name }) => name);
    const table = this.source.table(this.measure.name, names);
    const isEmpty = !names.length || (table[0]?.length ?? 0) === 0;
    this.empty.hidden = !isEmpty;
    this.place.hidden = isEmpty;
    if (isEmpty) return;
    const kind = `${this.measure.name} ${names.join()}`;
    if (kind !== this.drawn) {
      this.drawn = kind;
      this.#rebuild(named, table);
    } else this.plot?.setData(/** @type {uPlot.AlignedData} */ (table));
    const latest = named.map(({ label }, n) => `${label} ${this.#format(table[n + 1]?.at(-1) ?? null)}`);
    this.place.setAttribute("aria-label", `${this.measure.label}, iteration ${table[0]?.length ?? 0}: ${latest.join(", ")}`);
    this.chips.querySelectorAll("output").forEach((output, n) => (output.value = this.#format(table[n + 1]?.at(-1) ?? null)));
  }

  /** @param {number | null} value */
  #format(value) {
    if (value === null) return "–";
    return this.measure.share ? `${Math.round(value * 100)} %` : String(value);
  }

  /** @param {NamedLine[]} named @param {(number | null)[][]} table */
  #rebuild(named, table) {
    this.plot?.destroy();
    const axis = { stroke: INK, font: FONT, grid: { stroke: GRID, width: 1 }, ticks: { stroke: GRID, width: 1, size: 4 } };
    const { share } = this.measure;
    this.plot = new uPlot(
      {
        width: Math.max(120, this.place.clientWidth),
        height: Math.max(60, this.place.clientHeight),
        legend: { show: false },
        cursor: { show: false },
        padding: [6, 10, 0, 0],
        scales: { x: { time: false, range: (_, low, high) => [low, Math.max(high, low + 4)] }, y: { range: (_, low, high) => [Math.min(0, low), share ? Math.max(0.1, high) : Math.max(4, high * 1.05)] } },
        axes: [
          { ...axis, size: 26, gap: 3, incrs: [1, 2, 5, 10, 20, 25, 50, 100], space: 44 },
          { ...axis, size: 40, gap: 3, space: 24, ...(share ? {} : { incrs: [1, 2, 5, 10, 20, 50, 100] }), values: (_, ticks) => ticks.map((tick) => (share ? `${Math.round(tick * 100)} %` : String(tick))) },
        ],
        series: [{}, ...named.map(({ name, label }) => ({ label, ...(STYLES[name] ?? { stroke: INK }), show: !this.hidden.has(name), points: { show: (/** @type {uPlot} */ plot) => (plot.data[0]?.length ?? 0) < 2, size: 6, fill: STYLES[name]?.stroke ?? INK } }))],
      },
      /** @type {uPlot.AlignedData} */ (table),
      this.place,
    );
    this.chips.replaceChildren(...named.map((line, n) => this.#buildChip(line, n + 1)));
  }

  /** @param {NamedLine} line @param {number} series */
  #buildChip({ name, label }, series) {
    const { document } = this;
    const sample = build(document, "span", { class: "sample", "data-line": name, "aria-hidden": "true" });
    const chip = build(document, "button", { type: "button", class: "chip", "aria-pressed": String(!this.hidden.has(name)) }, sample, label, " ", build(document, "output", {}));
    chip.addEventListener("click", () => {
      if (!this.hidden.delete(name)) this.hidden.add(name);
      const shows = !this.hidden.has(name);
      chip.setAttribute("aria-pressed", String(shows));
      this.plot?.setSeries(series, { show: shows });
    });
    return chip;
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (this.plot && width && height) this.plot.setSize({ width, height });
  }
}
