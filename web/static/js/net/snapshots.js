// The robots between two snapshots: positions and headings are blended, states are taken as they were.

/** @typedef {import("./messages.js").Snapshot} Snapshot */
/** @typedef {import("./messages.js").RobotSample} RobotSample */

const SNAPSHOTS_KEPT = 24;
/** Beyond the newest snapshot robots go on for at most this many ticks, then stand. */
export const EXTRAPOLATED_TICKS = 3;
/** A jump longer than this between two snapshots is not blended. */
const JUMP_M = 1.5;

/** The shortest turn from one heading to another. @param {number} from @param {number} to @returns {number} radians in [-pi, pi) */
export function turnBetween(from, to) {
  const turn = (to - from) % (2 * Math.PI);
  if (turn >= Math.PI) return turn - 2 * Math.PI;
  return turn < -Math.PI ? turn + 2 * Math.PI : turn;
}

/** @param {RobotSample} a @param {RobotSample} b @param {number} t @returns {RobotSample} */
function blend(a, b, t) {
  if (Math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) > JUMP_M) return t < 0.5 ? a : b;
  return {
    x_m: a.x_m + (b.x_m - a.x_m) * t,
    y_m: a.y_m + (b.y_m - a.y_m) * t,
    heading: a.heading + turnBetween(a.heading, b.heading) * t,
    state: t < 1 ? a.state : b.state,
    carrying: t < 1 ? a.carrying : b.carrying,
  };
}

/** The latest snapshots in order of their ticks. */
export class SnapshotBuffer {
  constructor() {
    /** @type {Snapshot[]} */
    this.snapshots = [];
  }

  get newest() {
    return this.snapshots[this.snapshots.length - 1];
  }

  /** Keeps a snapshot; one that is not newer than the newest is dropped. @param {Snapshot} snapshot */
  push(snapshot) {
    const newest = this.newest;
    if (newest && snapshot.tick <= newest.tick) return;
    this.snapshots.push(snapshot);
    if (this.snapshots.length > SNAPSHOTS_KEPT) this.snapshots.shift();
  }

  clear() {
    this.snapshots.length = 0;
  }

  /**
   * The robots at a (fractional) tick; at either end of what is known they stand, or go on briefly.
   * @param {number} tick @returns {RobotSample[]} empty before the first snapshot
   */
  sample(tick) {
    const newest = this.newest;
    if (!newest) return [];
    let before = this.snapshots.length - 1;
    while (before > 0 && /** @type {Snapshot} */ (this.snapshots[before]).tick > tick) before -= 1;
    const a = /** @type {Snapshot} */ (this.snapshots[before]);
    const b = this.snapshots[before + 1];
    if (b && tick >= a.tick) return this.#between(a, b, (tick - a.tick) / (b.tick - a.tick));
    const previous = this.snapshots[before - 1];
    if (b || !previous || !(tick > newest.tick)) return a.robots;
    const ahead = Math.min(tick, newest.tick + EXTRAPOLATED_TICKS);
    return this.#between(previous, newest, (ahead - previous.tick) / (newest.tick - previous.tick));
  }

  /** @param {Snapshot} a @param {Snapshot} b @param {number} t */
  #between(a, b, t) {
    return a.robots.map((robot, n) => blend(robot, b.robots[n] ?? robot, t));
  }
}
