// The expert's keys: a robot's number, then an element. Letters count by what they type, or by their
// place where the layout has no such letter; digits count by their place.

/**
 * @typedef {{ type: "row", agent: number } | { type: "move", by: number } | { type: "side", by: number }
 *   | { type: "element", key: string } | { type: "column", key: string } | { type: "row-toggle" } | { type: "cell-toggle" }
 *   | { type: "right" } | { type: "all-right" } | { type: "undo" } | { type: "help" } | { type: "close" }
 *   | { type: "camera" } | { type: "numbers" } | { type: "refit" } | { type: "armed" }
 *   | { type: "unknown", sentence: string }} Command
 * @typedef {object} KeyPress the parts of a KeyboardEvent that count
 * @property {string} key @property {string} code @property {boolean} shiftKey @property {boolean} ctrlKey
 * @property {boolean} metaKey @property {boolean} altKey @property {boolean} repeat
 */

/** A second digit or a station's number must follow within this time. */
const WINDOW_MS = 1000;
const ELEMENTS = "tlgb";
const MOVES = /** @type {Record<string, Command>} */ ({
  ArrowUp: { type: "move", by: -1 }, ArrowDown: { type: "move", by: 1 },
  ArrowLeft: { type: "side", by: -1 }, ArrowRight: { type: "side", by: 1 },
});
const WORDS = /** @type {Record<string, Command>} */ ({
  r: { type: "right" }, u: { type: "undo" }, h: { type: "help" }, n: { type: "numbers" }, f: { type: "refit" },
  v: { type: "camera" },
});

/** The letter a key types, or the one at its place where it types none of a to z. @param {KeyPress} press */
function letterOf({ key, code }) {
  const typed = key.toLowerCase();
  if (/^[a-z]$/.test(typed)) return typed;
  return /^Key[A-Z]$/.test(code) && !/^[\x20-\x7e]$/.test(key) ? code.slice(3).toLowerCase() : "";
}

/** The digit of a key by its place, -1 for none. @param {string} code */
function digitOf(code) {
  const found = /^(?:Digit|Numpad)(\d)$/.exec(code);
  return found ? Number(found[1]) : -1;
}

/** Reads key presses; remembers a first digit or the S of a station for a moment. */
export class HotkeyReader {
  /** @param {number} robots @param {number} stations */
  constructor(robots, stations) {
    this.robots = robots;
    this.stations = stations;
    /** @type {{ digit: number, until_ms: number } | null} */
    this.first = null;
    this.stationUntil_ms = -Infinity;
  }

  #forget() {
    this.first = null;
    this.stationUntil_ms = -Infinity;
  }

  /** @param {KeyPress} press @param {number} now_ms @returns {Command | null} null for keys that mean nothing here */
  read(press, now_ms) {
    if (press.metaKey || press.altKey) return null;
    if (press.ctrlKey) return this.#readControlled(press);
    const digit = digitOf(press.code);
    if (press.key === "?") return { type: "help" };
    if (digit >= 0) return press.repeat ? null : this.#readDigit(digit, now_ms);
    const move = MOVES[press.key];
    if (move) {
      this.#forget();
      return move;
    }
    if (press.repeat) return null;
    return this.#readLetter(press, now_ms);
  }

  /** @param {KeyPress} press @returns {Command | null} */
  #readControlled(press) {
    return letterOf(press) === "z" && !press.repeat && !press.shiftKey ? { type: "undo" } : null;
  }

  /** @param {KeyPress} press @param {number} now_ms @returns {Command | null} */
  #readLetter(press, now_ms) {
    if (press.key === " ") return { type: "row-toggle" };
    if (press.key === "Enter") return { type: "cell-toggle" };
    if (press.key === "Escape") {
      this.#forget();
      return { type: "close" };
    }
    const letter = letterOf(press);
    if (letter === "s" && !press.shiftKey) {
      this.first = null;
      this.stationUntil_ms = now_ms + WINDOW_MS;
      return { type: "armed" };
    }
    if (!letter) return null;
    this.#forget();
    if (ELEMENTS.includes(letter)) return { type: press.shiftKey ? "column" : "element", key: letter.toUpperCase() };
    if (letter === "r" && press.shiftKey) return { type: "all-right" };
    return press.shiftKey ? null : (WORDS[letter] ?? null);
  }

  /** @param {number} digit @param {number} now_ms @returns {Command} */
  #readDigit(digit, now_ms) {
    if (now_ms <= this.stationUntil_ms) {
      this.#forget();
      if (digit >= 1 && digit <= this.stations) return { type: "row", agent: this.robots + digit - 1 };
      return { type: "unknown", sentence: `There is no station ${digit}.` };
    }
    const tens = this.first && now_ms <= this.first.until_ms ? this.first.digit : 0;
    const both = 10 * tens + digit;
    if (tens && both <= this.robots) {
      this.#forget();
      return { type: "row", agent: both - 1 };
    }
    const number = digit || 10;
    this.first = digit && 10 * digit <= this.robots ? { digit, until_ms: now_ms + WINDOW_MS } : null;
    if (number > this.robots) return { type: "unknown", sentence: `There is no robot ${number}.` };
    return { type: "row", agent: number - 1 };
  }
}
