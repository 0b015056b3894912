// The hall's plan is in metres with y up the page; three.js has y up to the ceiling. Everything
// crosses from one to the other here, and the heights that several parts must agree on are here too.

/**
 * @typedef {{ index: number, center_m: [number, number], bays: [number, number][] }} StationPlan
 * @typedef {object} HallPlan what the scene needs to know of the hall, metres and lattice cells
 * @property {number} hall_width_m @property {number} hall_height_m
 * @property {number[][]} shelves_m x0, y0, x1, y1 @property {number} box_seed
 * @property {StationPlan[]} stations @property {[number, number][]} homes
 * @property {number} eye_height_m
 *
 * @typedef {object} Sighting where a camera is and what it sees
 * @property {number} x @property {number} y @property {number} height_m
 * @property {number} heading @property {number} pitch radians
 * @property {number} [fov_deg] vertically @property {number} [near_m] @property {number} [far_m]
 *
 * @typedef {object} RobotSample a robot as it is drawn
 * @property {number} x_m @property {number} y_m @property {number} heading radians
 * @property {number} state @property {number} carrying colour of the box, -1 for none
 */

/** Heights in metres. */
export const CEILING_M = 5.4;
export const RACK_TOP_M = 2.28;
export const RACK_DECKS_M = Object.freeze([0.12, 0.84, 1.56]);
export const ROBOT_TOP_M = 0.42;
export const RIBBON_M = 0.02;

/** A carried box is smaller than the robot's top plate. Edge in metres. */
export const CARRIED_M = 0.27;

/**
 * What is seen through racks is drawn between the standing hall and the robots, so that racks do not
 * hide it and robots do.
 */
export const ORDER = Object.freeze({ hall: 0, hiddenRibbons: 1, solidAvatars: 2, robots: 3, shadows: 4, ribbons: 5, beads: 6, ghosts: 7, balloons: 8 });

/** Field of view, vertical, in degrees. */
export const FIELD_OF_VIEW_DEG = 60;

/** The camera looks along -z at rotation 0, the plan's heading 0 is +x. @param {number} heading radians */
export const cameraTurn = (heading) => heading - Math.PI / 2;

/** @param {number} cell lattice index along x @returns {number} metres */
export const cellX = (cell) => 0.3 + 0.6 * cell;
/** @param {number} cell lattice index along y @returns {number} metres */
export const cellY = (cell) => 0.9 + 0.6 * cell;

/**
 * A small seeded generator (mulberry32), so that a hall looks the same in every browser.
 * @param {number} seed @returns {() => number} values in [0, 1)
 */
export function seededRandom(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
