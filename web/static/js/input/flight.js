// Keys that move the camera, by their place on the keyboard, whatever the layout.

/** The keys of the camera that are held, by their place. */
const FLIGHT = /** @type {Record<string, [axis: "forward" | "right" | "turn" | "zoom", by: number]>} */ ({
  KeyW: ["forward", 1], KeyS: ["forward", -1], KeyD: ["right", 1], KeyA: ["right", -1],
  KeyQ: ["turn", 1], KeyE: ["turn", -1],
  Equal: ["zoom", 1], NumpadAdd: ["zoom", 1], BracketRight: ["zoom", 1], Minus: ["zoom", -1], NumpadSubtract: ["zoom", -1],
});

/** S also begins a station's number, so it moves the camera only when it is held. */
const DELAYS_MS = /** @type {Record<string, number>} */ ({ KeyS: 280 });

/** Which way the held keys move the camera. */
export class HeldFlight {
  constructor() {
    /** Held keys and since when they count, milliseconds. @type {Map<string, number>} */
    this.codes = new Map();
  }

  /** @param {string} code @param {number} now_ms @returns {boolean} whether the key moves the camera */
  press(code, now_ms) {
    if (!(code in FLIGHT)) return false;
    if (!this.codes.has(code)) this.codes.set(code, now_ms + (DELAYS_MS[code] ?? 0));
    return true;
  }

  /** @param {string} code */
  release(code) {
    this.codes.delete(code);
  }

  releaseAll() {
    this.codes.clear();
  }

  /** @param {number} now_ms @returns {{ forward: number, right: number, turn: number, zoom: number }} each -1, 0 or 1 */
  motion(now_ms) {
    const motion = { forward: 0, right: 0, turn: 0, zoom: 0 };
    for (const [code, since_ms] of this.codes) {
      const part = FLIGHT[code];
      if (part && now_ms >= since_ms) motion[part[0]] += part[1];
    }
    return motion;
  }

  get isIdle() {
    return this.codes.size === 0;
  }
}
