// What robots and stations are doing, in words, and for how long: read from the snapshots.

/** Words by RobotState number. */
export const STATE_WORDS = Object.freeze(["driving", "picking", "driving", "waiting", "unloading", "homeward", "home"]);
const TO_STATION = 2;
export const WAITING = 3;
/** A robot waits at the station whose bay it stands in: centre to centre at most this far, metres. */
const IN_BAY_M = 0.35;

/** @typedef {{ state: number, x_m: number, y_m: number }} RobotPlace */

/** Since which tick each robot has been in its state; for those seen from the start of it exactly. */
export class StateTimes {
  constructor() {
    /** @type {{ state: number, since: number, exact: boolean }[]} exact: its beginning was seen */
    this.robots = [];
    this.tick = 0;
  }

  clear() {
    this.robots.length = 0;
  }

  /** @param {number} tick @param {ReadonlyArray<RobotPlace>} robots */
  take(tick, robots) {
    this.tick = tick;
    robots.forEach(({ state }, robot) => {
      const known = this.robots[robot];
      if (known?.state !== state) this.robots[robot] = { state, since: tick, exact: known !== undefined };
    });
  }

  /** @param {number} robot @returns {string} such as “waiting 12 s”, or “12+ s” if it had begun unseen */
  describe(robot) {
    const known = this.robots[robot];
    if (!known) return "";
    const word = STATE_WORDS[known.state] ?? "";
    if (known.state === TO_STATION) return "with a box";
    return known.state === WAITING ? `${word} ${Math.floor((this.tick - known.since) / 30)}${known.exact ? "" : "+"} s` : word;
  }
}

/**
 * How many robots wait at each station.
 * @param {ReadonlyArray<RobotPlace>} robots @param {ReadonlyArray<{ bays: ReadonlyArray<readonly [number, number]> }>} stations with bays in metres
 */
export function countWaiting(robots, stations) {
  return stations.map(({ bays }) =>
    robots.filter(({ state, x_m, y_m }) =>
      state === WAITING && bays.some(([x, y]) => Math.hypot(x - x_m, y - y_m) < IN_BAY_M)).length);
}
