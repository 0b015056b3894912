// A robot's planned path as it is drawn: rounded turns, the distance from its start known at every
// point, and how far along it the robot has come.

import { cellX, cellY } from "./space.js";

/** @typedef {{ x: number, y: number, at: number }} PathPoint plan metres and metres from the start of the path */

const TURN_RADIUS_M = 0.28;
const TURN_STEPS = 6;
/** A robot is looked for this far behind and ahead of where it was last on its path. */
const SEARCH_BACK_M = 0.7;
const SEARCH_AHEAD_M = 3;

/**
 * Replaces every corner by an arc that touches both its legs.
 * @param {ReadonlyArray<readonly [number, number]>} corners metres @param {number} [radius_m]
 * @returns {PathPoint[]} with the distance from the first point
 */
export function roundPath(corners, radius_m = TURN_RADIUS_M) {
  /** @type {PathPoint[]} */
  const path = [];
  const add = (/** @type {number} */ x, /** @type {number} */ y) => {
    const last = path[path.length - 1];
    const step = last ? Math.hypot(x - last.x, y - last.y) : 0;
    if (!last || step > 1e-4) path.push({ x, y, at: (last?.at ?? 0) + step });
  };
  corners.forEach((corner, n) => {
    const before = corners[n - 1];
    const after = corners[n + 1];
    if (!before || !after) add(corner[0], corner[1]);
    else addArc(add, before, corner, after, radius_m);
  });
  return path;
}

/** @param {(x: number, y: number) => void} add @param {readonly [number, number]} a @param {readonly [number, number]} b @param {readonly [number, number]} next @param {number} radius_m */
function addArc(add, a, b, next, radius_m) {
  const inLength = Math.hypot(b[0] - a[0], b[1] - a[1]);
  const outLength = Math.hypot(next[0] - b[0], next[1] - b[1]);
  if (inLength < 1e-6 || outLength < 1e-6) return;
  const u = [(b[0] - a[0]) / inLength, (b[1] - a[1]) / inLength];
  const v = [(next[0] - b[0]) / outLength, (next[1] - b[1]) / outLength];
  const [ux = 0, uy = 0, vx = 0, vy = 0] = [...u, ...v];
  const turn = Math.atan2(ux * vy - uy * vx, ux * vx + uy * vy);
  const back = Math.min(radius_m * Math.tan(Math.min(Math.abs(turn), 2.6) / 2), inLength / 2.02, outLength / 2.02);
  if (Math.abs(turn) < 0.02 || back < 1e-3) {
    add(b[0], b[1]);
    return;
  }
  const radius = (back / Math.tan(Math.abs(turn) / 2)) * Math.sign(turn);
  const middle = [b[0] - ux * back - uy * radius, b[1] - uy * back + ux * radius];
  for (let n = 0; n <= TURN_STEPS; n += 1) {
    const angle = (turn * n) / TURN_STEPS;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    add((middle[0] ?? 0) + radius * (uy * c + ux * s), (middle[1] ?? 0) + radius * (uy * s - ux * c));
  }
}

/** @param {PathPoint[]} path @returns {number} metres */
export const pathLength = (path) => path[path.length - 1]?.at ?? 0;

/**
 * Place and heading at a distance along a path.
 * @param {PathPoint[]} path at least one point @param {number} at_m
 * @returns {{ x: number, y: number, heading: number }}
 */
export function pointAlong(path, at_m) {
  let n = 1;
  while (n < path.length - 1 && (path[n]?.at ?? 0) < at_m) n += 1;
  const a = path[n - 1] ?? { x: 0, y: 0, at: 0 };
  const b = path[n] ?? a;
  const t = b.at > a.at ? Math.max(0, Math.min(1, (at_m - a.at) / (b.at - a.at))) : 0;
  return { x: a.x + (b.x - a.x) * t, y: a.y + (b.y - a.y) * t, heading: Math.atan2(b.y - a.y, b.x - a.x) };
}

/** Corner cells in metres. @param {ReadonlyArray<readonly [number, number]>} cells @returns {[number, number][]} */
export const cornersInMetres = (cells) => cells.map(([i, j]) => [cellX(i), cellY(j)]);

/**
 * How far along its path a robot is, near where it was before.
 * @param {PathPoint[]} path @param {number} x @param {number} y @param {number} before_m @param {number} [ahead_m] how far to look
 * @returns {number} metres from the start
 */
export function progressAlong(path, x, y, before_m, ahead_m = SEARCH_AHEAD_M) {
  let best = Infinity;
  let progress = before_m;
  for (let n = 0; n + 1 < path.length; n += 1) {
    const a = /** @type {PathPoint} */ (path[n]);
    const b = /** @type {PathPoint} */ (path[n + 1]);
    if (b.at < before_m - SEARCH_BACK_M) continue;
    if (a.at > before_m + ahead_m) break;
    const [dx, dy] = [b.x - a.x, b.y - a.y];
    const t = Math.max(0, Math.min(1, ((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy || 1)));
    const gap = (x - a.x - t * dx) ** 2 + (y - a.y - t * dy) ** 2;
    if (gap < best - 1e-9) {
      best = gap;
      progress = a.at + t * (b.at - a.at);
    }
  }
  return progress;
}
