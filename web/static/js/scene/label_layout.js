// Keeps labels apart on the screen: the nearest keeps its place, others move up, and those that find
// no room fade.

/**
 * @typedef {object} Label
 * @property {number} x @property {number} y pixels, y down, of its middle
 * @property {number} w @property {number} h pixels
 * @property {number} depth_m nearer labels go first
 */
/** @typedef {{ dy: number, alpha: number }} Placement upward shift in pixels and strength */

const SHIFTS = Object.freeze([0, -1, -2, -3]);
const CROWDED_ALPHA = 0.22;

/** @param {Label} a @param {number} ay @param {Label} b @param {number} by */
const overlap = (a, ay, b, by) => Math.abs(a.x - b.x) < (a.w + b.w) / 2 && Math.abs(ay - by) < (a.h + b.h) / 2;

/** @param {Label[]} labels @returns {Placement[]} in the order given */
export function layOutLabels(labels) {
  /** @type {Placement[]} */
  const placements = labels.map(() => ({ dy: 0, alpha: CROWDED_ALPHA }));
  /** @type {[Label, number][]} */
  const taken = [];
  const order = labels.map((_, n) => n).sort((a, b) => (labels[a]?.depth_m ?? 0) - (labels[b]?.depth_m ?? 0));
  for (const n of order) {
    const label = /** @type {Label} */ (labels[n]);
    const shift = SHIFTS.find((rows) => {
      const y = label.y + rows * label.h;
      return taken.every(([other, at]) => !overlap(label, y, other, at));
    });
    if (shift === undefined) continue;
    placements[n] = { dy: shift * label.h, alpha: 1 };
    taken.push([label, label.y + shift * label.h]);
  }
  return placements;
}
