// What the grid knows: for each agent the expert's boxes, what is displayed, what draws anything, and
// who decides. Agents are numbered: robots from 0, then stations.

import { Edits } from "./edits.js";

/** @typedef {import("./edits.js").Change} Change */
/** @typedef {{ on: boolean, shown: boolean, drawn: boolean, proposed: boolean, pending: boolean }} CellState */
/** @typedef {{ name: string, title: string, key: string, bit: number, of: "robot" | "station" }} Column */
/** @typedef {{ boxes: number[], proposals: number[], drawn: number[], by_expert: number[], recording: boolean, taken_seq: number }} AgentsMessage */

/** The elements in the order of the grid's columns. @type {readonly Column[]} */
export const COLUMNS = Object.freeze([
  { name: "trajectory", title: "Trajectory", key: "T", bit: 4, of: "robot" },
  { name: "live_location", title: "Live", key: "L", bit: 1, of: "robot" },
  { name: "transparent_avatar", title: "Ghost", key: "G", bit: 2, of: "robot" },
  { name: "balloon", title: "Balloon", key: "B", bit: 1, of: "station" },
]);

/** The grid's facts and what the expert can do to them. */
export class Board {
  /** @param {number} robots @param {number} stations @param {Edits} edits */
  constructor(robots, stations, edits) {
    this.robots = robots;
    this.stations = stations;
    this.edits = edits;
    const agents = robots + stations;
    this.isKnown = false;
    this.recording = false;
    this.boxes = new Array(agents).fill(0);
    this.proposals = new Array(agents).fill(0);
    this.drawn = new Array(agents).fill(0);
    this.byExpert = new Array(agents).fill(0);
    this.shown = new Array(agents).fill(0);
  }

  get agents() {
    return this.robots + this.stations;
  }

  /** @param {number} agent */
  isRobot(agent) {
    return agent < this.robots;
  }

  /** Every element of an agent. @param {number} agent */
  full(agent) {
    return this.isRobot(agent) ? 7 : 1;
  }

  /** @param {number} agent @returns {readonly Column[]} */
  columns(agent) {
    return COLUMNS.filter(({ of }) => of === (this.isRobot(agent) ? "robot" : "station"));
  }

  /** @param {AgentsMessage} message */
  take(message) {
    this.isKnown = true;
    this.recording = message.recording;
    for (const [mine, theirs] of /** @type {[number[], number[]][]} */ ([
      [this.boxes, message.boxes], [this.proposals, message.proposals], [this.drawn, message.drawn], [this.byExpert, message.by_expert],
    ]))
      for (let agent = 0; agent < this.agents; agent += 1) mine[agent] = theirs[agent] ?? 0;
    this.edits.observe(message.taken_seq);
  }

  /** @param {{ robots: Uint8Array, stations: Uint8Array }} display */
  show(display) {
    for (let agent = 0; agent < this.agents; agent += 1)
      this.shown[agent] = this.isRobot(agent) ? (display.robots[agent] ?? 0) : (display.stations[agent - this.robots] ?? 0);
  }

  /** The expert's boxes of an agent, pending gestures included. @param {number} agent */
  box(agent) {
    return this.edits.overlay(agent, this.boxes[agent] ?? 0);
  }

  /** @param {number} agent @param {number} bit @returns {CellState} */
  cell(agent, bit) {
    const has = (/** @type {number[]} */ masks) => ((masks[agent] ?? 0) & bit) !== 0;
    return {
      on: (this.box(agent) & bit) !== 0,
      shown: has(this.shown),
      drawn: has(this.drawn),
      proposed: has(this.proposals),
      pending: (this.edits.pendingBits(agent) & bit) !== 0,
    };
  }

  /**
   * The change that switches some boxes: all off if every one of them is on, else all on.
   * @param {ReadonlyArray<[agent: number, bits: number]>} targets @returns {Change[]} only what differs
   */
  toggle(targets) {
    const allOn = targets.every(([agent, bits]) => (this.box(agent) & bits) === bits);
    const changes = targets.map(([agent, bits]) =>
      /** @type {Change} */ (allOn ? [agent, 0, bits] : [agent, bits & ~this.box(agent), 0]));
    return changes.filter(([, on, off]) => on || off);
  }

  /** @param {number} agent @param {number} bit */
  toggleCell(agent, bit) {
    return this.toggle([[agent, bit & this.full(agent)]]);
  }

  /** @param {number} agent */
  toggleRow(agent) {
    return this.toggle([[agent, this.full(agent)]]);
  }

  /** @param {Column} column */
  toggleColumn(column) {
    const agents = Array.from({ length: this.agents }, (_, agent) => agent);
    const mine = agents.filter((agent) => this.isRobot(agent) === (column.of === "robot"));
    return this.toggle(mine.map((agent) => [agent, column.bit]));
  }

  /** How many agents show the setting of the expert who leads at the moment. */
  get shownByExpert() {
    return this.byExpert.reduce((sum, own) => sum + (own ? 1 : 0), 0);
  }
}
