// Keys that move the camera, by their place on the keyboard, whatever the layout.

/** The keys of the camera that are held, by their place. */
const FLIGHT = /** @type {Record<string, [axis: "forward" | "right" | "turn" | "zoom", by: number]>} */ ({
  KeyW: ["forward", 1], KeyS: ["forward", -1], KeyD: ["right", 1], KeyA: ["right", -1],
  KeyQ: ["turn", 1], KeyE: ["turn", -1],
  Equal: ["zoom", 1], NumpadAdd: ["zoom", 1], BracketRight: ["zoom", 1], Minus: ["zoom", -1], NumpadSubtract: ["zoom", -1],
});

/** Which way the held keys move the camera. */
export class HeldFlight {
  constructor() {
    /** @type {Set<string>} */
    this.codes = new Set();
  }

  /** @param {string} code @returns {boolean} whether the key moves the camera */
  press(code) {
    if (!(code in FLIGHT)) return false;
    this.codes.add(code);
    return true;
  }

  /** @param {string} code */
  release(code) {
    this.codes.delete(code);
  }

  releaseAll() {
    this.codes.clear();
  }

  /** @returns {{ forward: number, right: number, turn: number, zoom: number }} each -1, 0 or 1 */
  get motion() {
    const motion = { forward: 0, right: 0, turn: 0, zoom: 0 };
    for (const code of this.codes) {
      const part = FLIGHT[code];
      if (part) motion[part[0]] += part[1];
    }
    return motion;
  }

  get isIdle() {
    return this.codes.size === 0;
  }
}
