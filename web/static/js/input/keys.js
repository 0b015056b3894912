// Which movement keys are held, by their place on the keyboard (event.code), whatever the layout.

import { KEY_A, KEY_D, KEY_S, KEY_W } from "./kinematics.js";

const MOVE_CODES = /** @type {Record<string, number>} */ ({
  KeyW: KEY_W, KeyA: KEY_A, KeyS: KEY_S, KeyD: KEY_D,
  ArrowUp: KEY_W, ArrowLeft: KEY_A, ArrowDown: KEY_S, ArrowRight: KEY_D,
});
const TURN_CODES = /** @type {Record<string, number>} */ ({ KeyQ: 1, KeyE: -1 });

/** The set of held keys; W and the up arrow may be held together and are told apart. */
export class HeldKeys {
  constructor() {
    /** @type {Set<string>} */
    this.codes = new Set();
  }

  /** @param {string} code event.code @returns {boolean} whether this key means something here */
  press(code) {
    if (!(code in MOVE_CODES) && !(code in TURN_CODES)) return false;
    this.codes.add(code);
    return true;
  }

  /** @param {string} code */
  release(code) {
    return this.codes.delete(code);
  }

  /** Lets go of everything: the page lost the keyboard and would never hear the release. */
  releaseAll() {
    this.codes.clear();
  }

  /** Bits KEY_* of the held movement keys. */
  get bits() {
    let bits = 0;
    for (const code of this.codes) bits |= MOVE_CODES[code] ?? 0;
    return bits;
  }

  /** 1 turning left (Q), -1 right (E), 0 neither or both. */
  get turn() {
    let turn = 0;
    for (const code of this.codes) turn += TURN_CODES[code] ?? 0;
    return turn;
  }
}
