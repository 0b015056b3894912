// Brings the participant's keys and mouse together: what is held, where the view turns, whether the
// page has the keyboard and the pointer.

import { HeldKeys } from "./input/keys.js";
import { Look } from "./input/look.js";
import { PointerLock } from "./input/pointer.js";

/**
 * @typedef {object} ControlHandlers
 * @property {() => void} help asked for
 * @property {(visible: boolean, focused: boolean, locked: boolean) => void} attention changed
 * @property {() => void} keysChanging called before the held keys change
 * @property {() => void} lockRefused
 */

/** Keyboard, mouse and attention of the page. */
export class Controls {
  /** @param {HTMLElement} surface that takes clicks and the pointer lock @param {ControlHandlers} handlers */
  constructor(surface, handlers) {
    this.handlers = handlers;
    this.held = new HeldKeys();
    this.look = new Look();
    this.document = surface.ownerDocument;
    this.enabled = true;
    this.attention = "";
    this.lastTurn_ms = NaN;
    this.pointer = new PointerLock(surface, {
      motion: (dx, dy) => this.look.moveMouse(dx, dy),
      change: (locked) => {
        if (!locked) this.#releaseAll();
        this.#report();
      },
      refused: () => handlers.lockRefused(),
    });
    surface.addEventListener("click", () => {
      if (this.enabled) void this.pointer.request();
    });
    surface.addEventListener("contextmenu", (event) => event.preventDefault());
    this.#listen(/** @type {Window} */ (this.document.defaultView));
  }

  /** @param {Window} window */
  #listen(window) {
    window.addEventListener("keydown", (event) => this.#press(event));
    window.addEventListener("keyup", (event) => {
      this.handlers.keysChanging();
      this.held.release(event.code);
    });
    window.addEventListener("blur", () => {
      this.#releaseAll();
      this.#report();
    });
    window.addEventListener("focus", () => this.#report());
    this.document.addEventListener("visibilitychange", () => {
      this.#releaseAll();
      this.#report();
    });
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.code === "KeyH" || event.key === "?") {
      if (!event.repeat) this.handlers.help();
      return;
    }
    if (!this.enabled) return;
    if (!event.repeat) this.handlers.keysChanging();
    if (this.held.press(event.code)) event.preventDefault();
  }

  #releaseAll() {
    this.handlers.keysChanging();
    this.held.releaseAll();
  }

  /** Whether the participant may move; otherwise all keys are let go. @param {boolean} enabled */
  setEnabled(enabled) {
    if (this.enabled === enabled) return;
    this.enabled = enabled;
    if (!enabled) this.#releaseAll();
  }

  /** Turns by Q and E for the time since the last call. @param {number} now_ms */
  turn(now_ms) {
    const passed_s = Math.min(0.1, Math.max(0, (now_ms - this.lastTurn_ms) / 1000)) || 0;
    this.lastTurn_ms = now_ms;
    if (this.held.turn) this.look.turn(this.held.turn, passed_s);
  }

  get isVisible() {
    return this.document.visibilityState === "visible";
  }

  /** Forgets what was reported, so that a new connection hears it again. */
  reportAgain() {
    this.attention = "";
    this.#report();
  }

  #report() {
    const state = /** @type {[boolean, boolean, boolean]} */ ([this.isVisible, this.document.hasFocus(), this.pointer.isLocked]);
    if (String(state) === this.attention) return;
    this.attention = String(state);
    this.handlers.attention(...state);
  }
}
