// The discrepancy curves as they arrive, iteration by iteration, and as a chart wants them.

/** @typedef {Record<string, number[]>} CurveLine values by measure */
/** @typedef {{ name: string, label: string }} NamedLine */

/** What the curves can show, in order. `share` marks values from 0 to 1. */
export const MEASURES = Object.freeze([
  { name: "disable", label: "Paper's count", help: "Elements the policy proposed and the expert has off, per iteration", share: false },
  { name: "enable", label: "Converse", help: "Elements the expert has on and the policy did not propose, per iteration", share: false },
  { name: "hamming_rate", label: "Hamming", help: "Share of the compared elements that differ, either way", share: true },
  { name: "shown_share", label: "Shown", help: "Share of the compared elements that are proposed on", share: true },
]);

/** Lines in order of drawing; those the server does not send are left out. */
export const LINES = Object.freeze([
  { name: "policy", label: "Policy" },
  { name: "arroch", label: "ARROCH" },
  { name: "all_off", label: "All off" },
  { name: "majority", label: "Majority" },
  { name: "floor", label: "Floor" },
]);

/** All values of all lines so far. */
export class CurveBook {
  constructor() {
    /** @type {Record<string, CurveLine>} */
    this.lines = {};
  }

  /** Takes values from an iteration on; later ones replace what was known. @param {{ from: number, lines: Record<string, CurveLine> }} message */
  take({ from, lines }) {
    for (const [name, measures] of Object.entries(lines)) {
      const line = (this.lines[name] ??= {});
      for (const [measure, values] of Object.entries(measures)) {
        if (!Array.isArray(values)) continue;
        const known = (line[measure] ??= []);
        known.length = Math.min(known.length, from);
        while (known.length < from) known.push(NaN);
        known.push(...values);
      }
    }
  }

  /** How many iterations are known. */
  get iterations() {
    return Math.max(0, ...Object.values(this.lines).flatMap((line) => Object.values(line).map((values) => values.length)));
  }

  /** The lines there are for a measure. @param {string} measure @returns {NamedLine[]} */
  named(measure) {
    return LINES.filter(({ name }) => (this.lines[name]?.[measure]?.length ?? 0) > 0);
  }

  /**
   * Columns for a chart: iterations from 1, then one column per line; null where nothing is known.
   * @param {string} measure @param {ReadonlyArray<string>} names @returns {(number | null)[][]}
   */
  table(measure, names) {
    const count = this.iterations;
    const x = Array.from({ length: count }, (_, n) => n + 1);
    const columns = names.map((name) =>
      x.map((_, n) => {
        const value = this.lines[name]?.[measure]?.[n];
        return value === undefined || Number.isNaN(value) ? null : value;
      }));
    return [x, ...columns];
  }
}
