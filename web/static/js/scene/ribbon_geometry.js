// The flat band along a path: two edge points per path point, mitred, with a round end at the goal.
// Pure numbers, so that its corners can be tested without a screen.

/** @typedef {import("./paths.js").PathPoint} PathPoint */

const NARROW_M = 0.09;
const WIDE_M = 0.3;
/** The width changes over this distance, then stays. */
const TAPER_M = 22;
const MITRE_MAX = 1.6;
const CAP_STEPS = 7;

/**
 * Width of a ribbon by the distance to the goal.
 * @param {number} toGoal_m @param {"goal" | "robot"} widestAt @returns {number} metres
 */
export function ribbonWidth(toGoal_m, widestAt) {
  const near = 1 - Math.min(1, Math.max(0, toGoal_m) / TAPER_M);
  const share = widestAt === "goal" ? near : 1 - near;
  return NARROW_M + (WIDE_M - NARROW_M) * share;
}

/** Sidewards step of a robot's ribbon, so that ribbons in one aisle lie beside each other. @param {number} robot @returns {number} metres to the left of travel */
export const laneOffset = (robot) => (((robot * 3) % 5) - 2) * 0.055;

/**
 * @typedef {object} Band
 * @property {number[]} centres x, y per vertex: the point the vertex belongs to
 * @property {number[]} sides x, y per vertex: from that point to the edge, metres
 * @property {number[]} across -1 left edge .. 1 right edge per vertex
 * @property {number[]} along metres from the robot per vertex
 * @property {number[]} indices triangles, anticlockwise seen from above
 */

/** Left normal of the way through point n, lengthened so that both legs keep their width. @param {PathPoint[]} path @param {number} n @returns {[number, number]} */
function mitre(path, n) {
  const here = /** @type {PathPoint} */ (path[n]);
  const before = path[n - 1] ?? here;
  const after = path[n + 1] ?? here;
  const a = Math.atan2(here.y - before.y, here.x - before.x);
  const b = Math.atan2(after.y - here.y, after.x - here.x);
  const first = before === here ? b : a;
  const second = after === here ? a : b;
  const half = Math.atan2(Math.sin(second - first), Math.cos(second - first)) / 2;
  const stretch = Math.min(MITRE_MAX, 1 / Math.max(0.2, Math.cos(half)));
  const heading = first + half;
  return [-Math.sin(heading) * stretch, Math.cos(heading) * stretch];
}

/**
 * @param {PathPoint[]} path at least two points @param {(toGoal_m: number) => number} width
 * @param {number} lane_m sidewards step to the left @returns {Band}
 */
export function buildBand(path, width, lane_m) {
  /** @type {Band} */
  const band = { centres: [], sides: [], across: [], along: [], indices: [] };
  const length = path[path.length - 1]?.at ?? 0;
  path.forEach((point, n) => {
    const [nx, ny] = mitre(path, n);
    const half = width(length - point.at) / 2;
    const lane = lane_m * Math.min(1, point.at / 0.5);
    for (const side of [1, -1]) {
      band.centres.push(point.x + nx * lane, point.y + ny * lane);
      band.sides.push(nx * half * side, ny * half * side);
      band.across.push(-side);
      band.along.push(point.at);
    }
    if (n > 0) {
      const at = 2 * n - 2;
      band.indices.push(at, at + 1, at + 2, at + 1, at + 3, at + 2);
    }
  });
  addRoundEnd(band, path);
  return band;
}

/** @param {Band} band @param {PathPoint[]} path */
function addRoundEnd(band, path) {
  const n = path.length - 1;
  const left = 2 * n;
  const [cx = 0, cy = 0] = band.centres.slice(2 * left, 2 * left + 2);
  const [sx = 0, sy = 0] = band.sides.slice(2 * left, 2 * left + 2);
  const centre = band.across.length;
  band.centres.push(cx, cy);
  band.sides.push(0, 0);
  band.across.push(0);
  band.along.push(path[n]?.at ?? 0);
  for (let step = 0; step <= CAP_STEPS; step += 1) {
    const angle = Math.PI + (Math.PI * step) / CAP_STEPS;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const next = band.across.length;
    band.centres.push(cx, cy);
    band.sides.push(sx * c - sy * s, sx * s + sy * c);
    band.across.push(1);
    band.along.push(path[n]?.at ?? 0);
    if (step > 0) band.indices.push(centre, next - 1, next);
  }
}
