// How the human moves in one input frame (1/30 s). The server runs the same arithmetic in the same
// order (study/warehouse/kinematics.py); a test holds the two equal to the bit, so change both.

export const KEY_W = 1;
export const KEY_A = 2;
export const KEY_S = 4;
export const KEY_D = 8;

/** Yaw is a 16-bit turn: 65536 steps anticlockwise from +x. */
export const YAW_STEPS = 65536;

const TABLE_SIZE = 4096;
const SCALE = 16777216;
const DIAGONAL = 0.70710678118654757;

/** Cosines of the 4096 directions, rounded to 2^-24 so that every machine has the same bits. */
export const TRIG_TABLE = Float64Array.from(
  { length: TABLE_SIZE },
  (_, k) => Math.round(Math.cos((2 * Math.PI * k) / TABLE_SIZE) * SCALE) / SCALE,
);

/** @typedef {{ x_m: number, y_m: number, blocked: boolean }} HumanState */

/**
 * @typedef {object} Hall what the human can bump into
 * @property {ReadonlyArray<ReadonlyArray<number>>} solids_m rectangles x0, y0, x1, y1
 * @property {number} human_speed_mps
 * @property {number} human_radius_m
 * @property {number} robot_radius_m
 */

/** @typedef {ReadonlyArray<{ x_m: number, y_m: number }>} Robots */

/**
 * Whether a circle at (x, y) overlaps any solid rectangle; touching is allowed.
 * @param {number} x @param {number} y @param {Hall} hall
 */
function overlapsSolid(x, y, hall) {
  const limit = hall.human_radius_m * hall.human_radius_m - 1e-9;
  for (const solid of hall.solids_m) {
    const x0 = /** @type {number} */ (solid[0]);
    const y0 = /** @type {number} */ (solid[1]);
    const x1 = /** @type {number} */ (solid[2]);
    const y1 = /** @type {number} */ (solid[3]);
    const ex = x - (x < x0 ? x0 : x > x1 ? x1 : x);
    const ey = y - (y < y0 ? y0 : y > y1 ? y1 : y);
    if (ex * ex + ey * ey < limit) return true;
  }
  return false;
}

/**
 * Whether a move from (x, y) to (nx, ny) would press into a robot and come closer to it.
 * @param {number} x @param {number} y @param {number} nx @param {number} ny
 * @param {Hall} hall @param {Robots} robots
 */
function pressesRobot(x, y, nx, ny, hall, robots) {
  const reach = hall.human_radius_m + hall.robot_radius_m;
  const limit = reach * reach - 1e-9;
  for (const robot of robots) {
    const ax = nx - robot.x_m;
    const ay = ny - robot.y_m;
    const after = ax * ax + ay * ay;
    if (after >= limit) continue;
    const bx = x - robot.x_m;
    const by = y - robot.y_m;
    if (after < bx * bx + by * by) return true;
  }
  return false;
}

/**
 * One frame of motion: keys relative to the view, x first, then y; a blocked axis stays where it is.
 * @param {{ x_m: number, y_m: number }} state @param {number} keys bits KEY_*
 * @param {number} yaw u16 @param {Hall} hall @param {Robots} robots
 * @returns {HumanState} the new state; `blocked` when a robot stopped it
 */
export function stepHuman(state, keys, yaw, hall, robots) {
  const f = (keys & KEY_W ? 1 : 0) - (keys & KEY_S ? 1 : 0);
  const r = (keys & KEY_D ? 1 : 0) - (keys & KEY_A ? 1 : 0);
  let { x_m: x, y_m: y } = state;
  if (f === 0 && r === 0) return { x_m: x, y_m: y, blocked: false };
  const k = (yaw & 65535) >> 4;
  const c = /** @type {number} */ (TRIG_TABLE[k]);
  const s = /** @type {number} */ (TRIG_TABLE[(k - 1024) & 4095]);
  let step = hall.human_speed_mps / 30;
  if (f !== 0 && r !== 0) step *= DIAGONAL;
  const dx = (f * c + r * s) * step;
  const dy = (f * s - r * c) * step;
  let blocked = false;
  const nx = x + dx;
  if (!overlapsSolid(nx, y, hall)) {
    if (pressesRobot(x, y, nx, y, hall, robots)) blocked = true;
    else x = nx;
  }
  const ny = y + dy;
  if (!overlapsSolid(x, ny, hall)) {
    if (pressesRobot(x, y, x, ny, hall, robots)) blocked = true;
    else y = ny;
  }
  return { x_m: x, y_m: y, blocked };
}
