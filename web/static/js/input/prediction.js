// The own human moves at once: every frame is applied here and kept until the server has
// acknowledged it. Where the server ended elsewhere (a robot was in the way), the human is set back
// to the server's place, the frames still under way are replayed, and the difference fades out.

import { stepHuman, trigTable } from "./kinematics.js";

/** @typedef {import("./kinematics.js").Solids} Solids */
/** @typedef {import("./kinematics.js").RobotPlaces} Robots */
/** @typedef {{ solids_m: Solids, human_speed_mps: number }} Hall what the human can bump into */
/** @typedef {{ x_m: number, y_m: number }} Place */
/** @typedef {{ keys: number, yaw: number }} Frame */
/** @typedef {{ seq: number, keys: number, yaw: number, x_m: number, y_m: number }} PendingFrame */

/** Snapshots carry positions in steps of 1/512 m; smaller differences are only rounding. */
const AGREEMENT_M = 1.5 / 512;
const FADE_S = 0.09;
const SNAP_M = 0.6;
const SEQ_MODULUS = 65536;

/** Predicted state of the own human. */
export class Prediction {
  /** @param {Hall} hall @param {Place} start @param {number} acknowledged last sequence number the server has consumed */
  constructor(hall, start, acknowledged) {
    this.hall = hall;
    this.step_m = hall.human_speed_mps / 30;
    this.cosines = trigTable();
    this.x_m = start.x_m;
    this.y_m = start.y_m;
    this.seq = acknowledged;
    /** @type {PendingFrame[]} */
    this.pending = [];
    this.offset = { x_m: 0, y_m: 0 };
    this.correction_m = 0;
    /** @type {PendingFrame | null} the newest acknowledged frame with the place predicted for it */
    this.settled = null;
  }

  /** @param {Place} from @param {Frame} frame @param {Robots} robots @returns {Place} */
  #step(from, frame, robots) {
    const place = { x: from.x_m, y: from.y_m };
    const next = stepHuman(place, frame.keys, frame.yaw, this.step_m, this.cosines, this.hall.solids_m, robots);
    return { x_m: next.x, y_m: next.y };
  }

  /** Applies one frame now. @param {Frame} frame @param {Robots} robots @returns {number} its sequence number */
  apply(frame, robots) {
    const next = this.#step(this, frame, robots);
    this.x_m = next.x_m;
    this.y_m = next.y_m;
    this.seq += 1;
    this.pending.push({ seq: this.seq, keys: frame.keys, yaw: frame.yaw, x_m: this.x_m, y_m: this.y_m });
    return this.seq;
  }

  /**
   * Takes the server's word.
   * @param {number} acknowledged u16 of the newest consumed sequence number
   * @param {Place} place where the server has the human after it
   * @param {Robots} robots
   */
  reconcile(acknowledged, place, robots) {
    while (this.pending.length && this.#isCovered(/** @type {PendingFrame} */ (this.pending[0]), acknowledged))
      this.settled = this.pending.shift() ?? null;
    const known = this.settled;
    if (known && known.seq % SEQ_MODULUS === acknowledged) {
      if (Math.hypot(known.x_m - place.x_m, known.y_m - place.y_m) <= AGREEMENT_M) return;
    } else if (!this.pending.length && Math.hypot(this.x_m - place.x_m, this.y_m - place.y_m) <= AGREEMENT_M) return;
    this.#replay(place, robots);
    if (known) Object.assign(known, { x_m: place.x_m, y_m: place.y_m });
  }

  /** Frames the server will never consume (a pause came between). @param {Place} place */
  dropPending(place) {
    this.seq -= this.pending.length;
    this.pending.length = 0;
    this.settled = null;
    this.#moveTo(place.x_m, place.y_m);
  }

  /** Sets the numbering after a reconnect. @param {Place} place @param {number} acknowledged */
  restart(place, acknowledged) {
    this.pending.length = 0;
    this.settled = null;
    this.seq = acknowledged;
    this.#moveTo(place.x_m, place.y_m);
  }

  /** @param {PendingFrame} frame @param {number} acknowledged */
  #isCovered(frame, acknowledged) {
    const ahead = (acknowledged - (frame.seq % SEQ_MODULUS) + SEQ_MODULUS) % SEQ_MODULUS;
    return ahead < SEQ_MODULUS / 2;
  }

  /** @param {Place} place @param {Robots} robots */
  #replay(place, robots) {
    let at = { x_m: place.x_m, y_m: place.y_m };
    for (const frame of this.pending) {
      at = this.#step(at, frame, robots);
      frame.x_m = at.x_m;
      frame.y_m = at.y_m;
    }
    this.#moveTo(at.x_m, at.y_m);
  }

  /** Moves the true place; what is drawn keeps its place and follows smoothly. @param {number} x_m @param {number} y_m */
  #moveTo(x_m, y_m) {
    this.correction_m = Math.hypot(this.x_m - x_m, this.y_m - y_m);
    this.offset.x_m += this.x_m - x_m;
    this.offset.y_m += this.y_m - y_m;
    if (Math.hypot(this.offset.x_m, this.offset.y_m) > SNAP_M) this.offset = { x_m: 0, y_m: 0 };
    this.x_m = x_m;
    this.y_m = y_m;
  }

  /** Keeps the picture steady when the running frame's keys change. @param {Place} before @param {Place} after both as drawn */
  absorb(before, after) {
    this.offset.x_m += before.x_m - after.x_m;
    this.offset.y_m += before.y_m - after.y_m;
  }

  /** @param {number} seconds since the last drawn frame */
  fade(seconds) {
    const kept = Math.exp(-seconds / FADE_S);
    this.offset.x_m *= kept;
    this.offset.y_m *= kept;
  }

  /**
   * The place to draw: the running frame is shown as far as it has come, so a key press is seen at once.
   * @param {Frame} frame held keys now @param {number} fraction of the running frame @param {Robots} robots
   */
  drawn(frame, fraction, robots) {
    const next = frame.keys === 0 ? this : this.#step(this, frame, robots);
    return {
      x_m: this.x_m + (next.x_m - this.x_m) * fraction + this.offset.x_m,
      y_m: this.y_m + (next.y_m - this.y_m) * fraction + this.offset.y_m,
    };
  }
}
