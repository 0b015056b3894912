// How the human moves in one input frame (1/30 s): push out of what is in the way, up to three times,
// so that the body slides along walls, racks and robots. The server runs the same arithmetic in the
// same order (study/warehouse/kinematics.py); a test holds the two equal to the bit: change both.

export const KEY_W = 1;
export const KEY_A = 2;
export const KEY_S = 4;
export const KEY_D = 8;

/** Yaw is a 16-bit turn: 65536 steps anticlockwise from +x. */
export const YAW_STEPS = 65536;

const SKIN = 1 / 8192;
const BODY = 0.3 + SKIN;
const BODY2 = BODY * BODY;
const PAIR = 0.5 + SKIN;
const PAIR2 = PAIR * PAIR;
const BODY_MIN2 = 0.3 * 0.3;
const PAIR_MIN2 = 0.5 * 0.5;
const DIAGONAL = 0.7071067811865476;
const PASSES = 3;

/** @typedef {ReadonlyArray<ReadonlyArray<number>>} Solids rectangles x0, y0, x1, y1 in metres */
/** @typedef {ReadonlyArray<ReadonlyArray<number>>} RobotPlaces x, y in metres, all robots in order */
/** @typedef {{ x: number, y: number, contact: boolean }} Step where the human is; whether a robot was touched */

/** Cosines of the 4096 directions, rounded to 2^-24 so that every machine has the same bits. */
export function trigTable() {
  const table = new Float64Array(4096);
  for (let k = 0; k < 4096; k += 1)
    table[k] = Math.floor(Math.cos((2 * Math.PI * k) / 4096) * 16777216 + 0.5) / 16777216;
  return table;
}

/** The coordinate of an interval nearest to a point. @param {number} p @param {number} low @param {number} high */
const nearest = (p, low, high) => (p < low ? low : p > high ? high : p);

/** @param {ReadonlyArray<number>} row @param {number} at */
const entry = (row, at) => /** @type {number} */ (row[at]);

/**
 * One pass over everything solid: whoever overlaps pushes the human out along the shortest way.
 * @param {{ x: number, y: number, contact: boolean, inside: boolean }} at changed in place
 * @param {Solids} solids @param {RobotPlaces} robots @returns {boolean} whether anything pushed
 */
function pushOut(at, solids, robots) {
  let moved = false;
  for (const solid of solids) {
    const qx = nearest(at.x, entry(solid, 0), entry(solid, 2));
    const qy = nearest(at.y, entry(solid, 1), entry(solid, 3));
    moved = pushFrom(at, qx, qy, BODY, BODY2) || moved;
  }
  for (const robot of robots) {
    const ux = at.x - entry(robot, 0);
    const uy = at.y - entry(robot, 1);
    if (ux * ux + uy * uy < PAIR2) at.contact = true;
    moved = pushFrom(at, entry(robot, 0), entry(robot, 1), PAIR, PAIR2) || moved;
  }
  return moved;
}

/**
 * @param {{ x: number, y: number, inside: boolean }} at @param {number} qx @param {number} qy
 * @param {number} reach @param {number} reach2 its square @returns {boolean} whether it pushed
 */
function pushFrom(at, qx, qy, reach, reach2) {
  const ux = at.x - qx;
  const uy = at.y - qy;
  const d2 = ux * ux + uy * uy;
  if (!(d2 < reach2)) return false;
  if (d2 === 0) {
    at.inside = true;
    return false;
  }
  const g = reach / Math.sqrt(d2);
  at.x = qx + ux * g;
  at.y = qy + uy * g;
  return true;
}

/** @param {number} x @param {number} y @param {Solids} solids @param {RobotPlaces} robots */
function isFree(x, y, solids, robots) {
  for (const solid of solids) {
    const ux = x - nearest(x, entry(solid, 0), entry(solid, 2));
    const uy = y - nearest(y, entry(solid, 1), entry(solid, 3));
    if (ux * ux + uy * uy < BODY_MIN2) return false;
  }
  for (const robot of robots) {
    const ux = x - entry(robot, 0);
    const uy = y - entry(robot, 1);
    if (ux * ux + uy * uy < PAIR_MIN2) return false;
  }
  return true;
}

/**
 * One frame of motion, keys relative to the view.
 * @param {{ x: number, y: number }} place metres @param {number} keys bits KEY_* @param {number} yaw u16
 * @param {number} stepM human_speed_mps / 30 @param {Float64Array} cosines from trigTable()
 * @param {Solids} solids @param {RobotPlaces} robots @returns {Step}
 */
export function stepHuman(place, keys, yaw, stepM, cosines, solids, robots) {
  const { x, y } = place;
  const f = (keys & KEY_W ? 1 : 0) - (keys & KEY_S ? 1 : 0);
  const r = (keys & KEY_D ? 1 : 0) - (keys & KEY_A ? 1 : 0);
  if (f === 0 && r === 0) return { x, y, contact: false };
  const k = yaw >> 4;
  const c = /** @type {number} */ (cosines[k]);
  const s = /** @type {number} */ (cosines[(k - 1024) & 4095]);
  let dx = f * c + r * s;
  let dy = f * s - r * c;
  if (f !== 0 && r !== 0) {
    dx *= DIAGONAL;
    dy *= DIAGONAL;
  }
  dx *= stepM;
  dy *= stepM;
  const at = { x: x + dx, y: y + dy, contact: false, inside: false };
  for (let pass = 0; pass < PASSES; pass += 1) if (!pushOut(at, solids, robots)) break;
  const { contact } = at;
  if (!at.inside && isFree(at.x, at.y, solids, robots)) return { x: at.x, y: at.y, contact };
  if (isFree(x + dx, y, solids, robots)) return { x: x + dx, y, contact };
  if (isFree(x, y + dy, solids, robots)) return { x, y: y + dy, contact };
  return { x, y, contact };
}
