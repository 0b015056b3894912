// The expert's desk: the grid, what is done in it by keys and mouse, and what became of that.

import { Board, COLUMNS } from "./expert/board.js";
import { Edits } from "./expert/edits.js";
import { HotkeyReader } from "./input/hotkeys.js";
import { robotColour, smallInkOn, STATION_COLOURS } from "./scene/palette.js";
import { AgentGrid } from "./ui/agent_grid.js";

/** @typedef {import("./expert/edits.js").Gesture} Gesture */
/** @typedef {import("./expert/edits.js").Change} Change */
/** @typedef {import("./input/hotkeys.js").Command} Command */
/**
 * @typedef {object} DeskHandlers
 * @property {() => { trial: number, tick: number } | string} moment the moment on the screen, or why nothing can be set
 * @property {(gesture: Gesture) => void} send
 * @property {(text: string, isRefusal?: boolean) => void} say
 * @property {(agent: number) => void} chosen
 */

/** A refused cell shows so for this long. */
const REFUSED_MS = 2500;
/** “This row is right” counts for so many ticks. */
const CONFIRMED_TICKS = 240;

/** @param {number} robots @param {number} stations */
function describeRows(robots, stations) {
  return Array.from({ length: robots + stations }, (_, agent) => {
    const isRobot = agent < robots;
    const index = isRobot ? agent : agent - robots;
    const colour = isRobot ? robotColour(index) : (STATION_COLOURS[index % STATION_COLOURS.length] ?? "#888888");
    const number = isRobot ? String(index + 1) : `S${index + 1}`;
    return {
      number, key: isRobot ? number : `S then ${index + 1}`, name: `${isRobot ? "Robot" : "Station"} ${index + 1}`,
      colour, ink: smallInkOn(colour), columns: COLUMNS.filter(({ of }) => of === (isRobot ? "robot" : "station")),
    };
  });
}

/** Grid, cursor, gestures. */
export class Desk {
  /** @param {HTMLElement} parent @param {{ robots: number, stations: number }} counts @param {DeskHandlers} handlers */
  constructor(parent, { robots, stations }, handlers) {
    this.handlers = handlers;
    this.edits = new Edits();
    this.board = new Board(robots, stations, this.edits);
    this.reader = new HotkeyReader(robots, stations);
    this.heads = describeRows(robots, stations);
    this.agent = 0;
    this.side = 0;
    /** Whether this page's boxes are those that count. */
    this.isLead = true;
    /** @type {string[]} what each robot or station does */
    this.statuses = new Array(robots + stations).fill("");
    /** @type {Map<number, { bits: number, until_ms: number }>} */
    this.refusals = new Map();
    /** @type {Map<number, number>} last tick for which a row counts as right */
    this.confirmed = new Map();
    this.grid = new AgentGrid(parent, this.heads, {
      choose: (agent, side) => this.choose(agent, side),
      cell: (agent, bit) => this.#edit(this.board.toggleCell(agent, bit)),
      column: (key) => this.run({ type: "column", key }),
      right: (agent) => this.#confirm([agent]),
    });
    this.choose(0, 0);
  }

  /** @param {number} agent @param {number} side */
  choose(agent, side) {
    this.agent = agent;
    this.side = Math.min(side, this.board.columns(agent).length - 1);
    this.grid.choose(agent, this.side);
    this.handlers.chosen(agent);
    this.render();
  }

  /** Does what a key asked for. @param {Command} command @returns {boolean} whether it was the desk's */
  run(command) {
    const { board, agent } = this;
    if (command.type === "row") this.choose(command.agent, this.side);
    else if (command.type === "move") this.choose((agent + command.by + board.agents) % board.agents, this.side);
    else if (command.type === "side") this.choose(agent, (this.side + command.by + board.columns(agent).length) % board.columns(agent).length);
    else if (command.type === "element") this.#toggleElement(command.key);
    else if (command.type === "column") this.#edit(board.toggleColumn(this.#column(command.key)));
    else if (command.type === "row-toggle") this.#edit(board.toggleRow(agent));
    else if (command.type === "cell-toggle") this.#edit(board.toggleCell(agent, board.columns(agent)[this.side]?.bit ?? 0));
    else if (command.type === "right") this.#confirm([agent]);
    else if (command.type === "all-right") this.#confirm(Array.from({ length: board.agents }, (_, n) => n));
    else if (command.type === "undo") this.#undo();
    else if (command.type === "unknown") this.handlers.say(command.sentence, true);
    else return command.type === "armed";
    return true;
  }

  /** @param {string} key */
  #column(key) {
    return /** @type {typeof COLUMNS[number]} */ (COLUMNS.find((column) => column.key === key));
  }

  /** @param {string} key */
  #toggleElement(key) {
    const column = this.#column(key);
    const isRobot = this.board.isRobot(this.agent);
    const { name = "" } = this.heads[this.agent] ?? {};
    if (isRobot && column.of === "station") return this.handlers.say(`${name} has no balloon; stations have (S, then a number).`, true);
    if (!isRobot && column.of === "robot") return this.handlers.say(`${name} has a balloon only (B).`, true);
    this.side = this.board.columns(this.agent).indexOf(column);
    this.grid.choose(this.agent, this.side);
    this.#edit(this.board.toggleCell(this.agent, column.bit));
  }

  /** @returns {{ trial: number, tick: number } | null} null and a word to the expert if nothing can be set now */
  #moment() {
    const moment = this.handlers.moment();
    if (typeof moment !== "string") return moment;
    this.handlers.say(moment, true);
    return null;
  }

  /** @param {Change[]} changes */
  #edit(changes) {
    const when = changes.length ? this.#moment() : null;
    if (!when) return;
    this.#send(this.edits.edit(when, changes));
    this.handlers.say(this.#describe(changes));
  }

  /** @param {number[]} agents */
  #confirm(agents) {
    const when = this.#moment();
    if (!when) return;
    this.#send(this.edits.confirm(when, agents));
    this.handlers.say(agents.length > 1 ? "All rows are right" : `${this.heads[agents[0] ?? 0]?.name} is right`);
  }

  #undo() {
    const when = this.#moment();
    if (!when) return;
    const gesture = this.edits.undo(when);
    if (!gesture) return this.handlers.say("There is nothing to take back.");
    this.#send(gesture);
    this.handlers.say(`Taken back: ${this.#describe(gesture.changes)}`);
  }

  /** @param {Gesture} gesture */
  #send(gesture) {
    for (const [agent] of gesture.changes) this.refusals.delete(agent);
    this.handlers.send(gesture);
    this.render();
  }

  /** @param {Change[]} changes @returns {string} */
  #describe(changes) {
    const [first] = changes;
    if (!first) return "";
    const [agent, on, off] = first;
    const verb = on && off ? "changed" : on ? "on" : "off";
    if (changes.length > 1) return `${changes.length} rows ${verb}`;
    const parts = this.board.columns(agent).filter(({ bit }) => (on | off) & bit);
    return `${this.heads[agent]?.name}: ${parts.map(({ title }) => title.toLowerCase()).join(", ")} ${verb}`;
  }

  /** @param {number} seq */
  settle(seq) {
    for (const { kind, agents, tick } of this.edits.settle(seq))
      if (kind === "confirm") for (const agent of agents) this.confirmed.set(agent, tick + CONFIRMED_TICKS);
    this.render();
  }

  /** @param {number} seq @param {string} sentence */
  refuse(seq, sentence) {
    const gesture = this.edits.refuse(seq);
    const until_ms = performance.now() + REFUSED_MS;
    for (const [agent, on, off] of gesture?.changes ?? []) this.refusals.set(agent, { bits: on | off, until_ms });
    this.handlers.say(`Refused: ${sentence}`, true);
    this.render();
    if (gesture) setTimeout(() => this.render(), REFUSED_MS + 20);
  }

  /** This page leads, or does not: with the lead it goes over to other boxes. @param {boolean} isLead */
  lead(isLead) {
    if (isLead !== this.isLead) this.edits.forgetUndo();
    this.isLead = isLead;
    this.render();
  }

  /** Begins another trial: nothing is known of it yet. */
  beginTrial() {
    this.confirmed.clear();
    this.statuses.fill("");
    this.render();
  }

  /** Shows what is known. @param {number} [tick] of the trial, to let confirmations lapse */
  render(tick) {
    if (tick !== undefined) for (const [agent, until] of this.confirmed) if (tick > until) this.confirmed.delete(agent);
    const now_ms = performance.now();
    const expert = this.isLead ? "expert" : "lead";
    this.grid.show(this.heads.map((head, agent) => {
      const refusal = this.refusals.get(agent);
      const refused = refusal && refusal.until_ms > now_ms ? refusal.bits : 0;
      const cells = head.columns.map(({ bit }) => ({ ...this.board.cell(agent, bit), refused: (refused & bit) !== 0 }));
      const confirmed = this.edits.isConfirming(agent) ? "pending" : this.confirmed.has(agent) ? "done" : "";
      const owner = !this.board.isKnown ? "" : this.board.byExpert[agent] ? expert : "policy";
      return { status: this.statuses[agent] ?? "", chosen: agent === this.agent, owner, confirmed, cells };
    }));
  }
}
