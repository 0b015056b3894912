// What the expert did and what became of it: gestures wait until the server has stored or refused
// them, are sent again after a lost connection, and can be taken back.

/** @typedef {[agent: number, on: number, off: number]} Change bits to set and bits to clear */
/**
 * @typedef {object} Gesture one toggle, row, column, undo, or “this row is right”
 * @property {number} seq from 1 per page @property {"edit" | "confirm"} kind
 * @property {number} trial @property {number} tick when the expert made it
 * @property {Change[]} changes of an edit @property {number[]} agents of a confirmation
 * @property {boolean} applied the server's boxes hold it
 */

const UNDO_DEPTH = 200;

/** @param {Change[]} changes @returns {Change[]} */
export const inverse = (changes) => changes.map(([agent, on, off]) => [agent, off, on]);

/** The gestures of one page in order of their numbers. */
export class Edits {
  constructor() {
    this.seq = 0;
    /** How many gestures are stored for good. */
    this.stored = 0;
    /** Sent or to be sent, not yet stored. @type {Gesture[]} */
    this.pending = [];
    /** Own edits that undo can take back, the newest last. @type {Gesture[]} */
    this.undoable = [];
  }

  /** @param {{ trial: number, tick: number }} when @param {Change[]} changes @returns {Gesture} */
  edit(when, changes) {
    const gesture = this.#add(when, "edit", changes, []);
    this.undoable.push(gesture);
    if (this.undoable.length > UNDO_DEPTH) this.undoable.shift();
    return gesture;
  }

  /** @param {{ trial: number, tick: number }} when @param {number[]} agents @returns {Gesture} */
  confirm(when, agents) {
    return this.#add(when, "confirm", [], agents);
  }

  /** Takes back the newest own edit by the inverse change. @param {{ trial: number, tick: number }} when @returns {Gesture | null} null if there is none */
  undo(when) {
    const last = this.undoable.pop();
    return last ? this.#add(when, "edit", inverse(last.changes), []) : null;
  }

  /** The page sets other boxes from now on: what was done to the former ones cannot be taken back in these. */
  forgetUndo() {
    this.undoable.length = 0;
  }

  /** @param {{ trial: number, tick: number }} when @param {"edit" | "confirm"} kind @param {Change[]} changes @param {number[]} agents */
  #add({ trial, tick }, kind, changes, agents) {
    this.seq += 1;
    /** @type {Gesture} */
    const gesture = { seq: this.seq, kind, trial, tick, changes, agents, applied: false };
    this.pending.push(gesture);
    return gesture;
  }

  /** Everything up to a number is stored. @param {number} seq @returns {Gesture[]} those that were waiting for it */
  settle(seq) {
    const done = this.pending.filter((gesture) => gesture.seq <= seq);
    this.pending = this.pending.filter((gesture) => gesture.seq > seq);
    this.stored += done.length;
    return done;
  }

  /** Nothing of a gesture was applied. @param {number} seq @returns {Gesture | null} */
  refuse(seq) {
    const refused = this.pending.find((gesture) => gesture.seq === seq) ?? null;
    this.pending = this.pending.filter((gesture) => gesture.seq !== seq);
    this.undoable = this.undoable.filter((gesture) => gesture.seq !== seq);
    return refused;
  }

  /** The server told boxes that hold every gesture up to a number: those are laid over them no more. @param {number} seq */
  observe(seq) {
    for (const gesture of this.pending) if (gesture.seq <= seq) gesture.applied = true;
  }

  /**
   * A trial is at a tick. A server that was killed begins again a moment before the last ones that this
   * page saw, so what waits was made, for the server, at this tick.
   * @param {number} trial @param {number} tick
   */
  rewind(trial, tick) {
    for (const gesture of this.pending) {
      gesture.applied = false;
      if (gesture.trial === trial) gesture.tick = Math.min(gesture.tick, tick);
    }
  }

  /** A mask as it will be once the pending gestures have arrived. @param {number} agent @param {number} mask */
  overlay(agent, mask) {
    for (const gesture of this.pending) {
      if (gesture.applied) continue;
      for (const [of, on, off] of gesture.changes) if (of === agent) mask = (mask | on) & ~off;
    }
    return mask;
  }

  /** Bits of an agent that wait to be stored. @param {number} agent */
  pendingBits(agent) {
    let bits = 0;
    for (const { changes } of this.pending) for (const [of, on, off] of changes) if (of === agent) bits |= on | off;
    return bits;
  }

  /** Whether “this row is right” of an agent waits to be stored. @param {number} agent */
  isConfirming(agent) {
    return this.pending.some(({ agents }) => agents.includes(agent));
  }
}
