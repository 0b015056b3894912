// One trial as staff watch it: picture, cameras, the moment shown, and a replay's controls.

import { Connection } from "./net/connection.js";
import { decodeText, encodeHello } from "./net/messages.js";
import { CAMERA_MODES } from "./scene/cameras.js";
import { Spectator } from "./spectator.js";
import { CameraBar } from "./ui/camera_bar.js";

/** @typedef {import("./net/messages.js").TextMessage | { type: "length", ticks: number }} StaffText */
/** @typedef {{ live: string, replay: string, isReplay: boolean, antialias: "auto" | "on" | "off" }} Addresses */

const TICK_HZ = 30;
const STATES = /** @type {Record<string, string>} */ ({
  connecting: "Connecting …", open: "", lost: "Connection lost, trying again …", "taken-over": "Opened elsewhere.",
});
const PHASES = /** @type {Record<string, string>} */ ({
  waiting: "Waiting for the participant", countdown: "About to start", running: "Running", paused: "Paused", finished: "Over",
});

/** @param {string} text @returns {StaffText} */
function decode(text) {
  const message = JSON.parse(text);
  return message?.type === "length" && Number.isInteger(message.ticks) ? message : decodeText(text);
}

/** The page of one watched trial. */
export class WatchedTrial {
  /** @param {Document} document @param {Addresses} addresses */
  constructor(document, addresses) {
    this.document = document;
    this.addresses = addresses;
    const place = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
    this.stage = place("stage");
    this.line = place("line");
    this.clock = place("clock");
    this.tickField = /** @type {HTMLInputElement} */ (place("tick"));
    this.seek = /** @type {HTMLInputElement | null} */ (document.getElementById("seek"));
    this.play = document.getElementById("play");
    this.phase = "waiting";
    this.wanted_tick = Number(/^#tick=(\d{1,9})$/.exec(location.hash)?.[1] ?? NaN);
    const cameras = new CameraBar(place("cameras"), CAMERA_MODES, {
      choose: (mode) => this.spectator.choose(/** @type {import("./scene/cameras.js").CameraMode} */ (mode)),
      refit: () => this.spectator.cameras?.refit(),
      numbers: () => this.spectator.toggleNumbers(),
    });
    this.spectator = new Spectator(this.stage, addresses.antialias, {
      chosen: () => {},
      cameraChanged: (mode) => cameras.show(mode),
    });
    this.connection = new Connection(
      addresses.live,
      { message: (message) => this.#hear(message), state: (state, reason) => this.#lineChanged(state, reason) },
      { hello: encodeHello, decode, greeting: "welcome" },
    );
    this.#listen();
    const draw = (/** @type {number} */ now_ms) => {
      requestAnimationFrame(draw);
      this.spectator.draw(now_ms);
      this.#showMoment();
    };
    requestAnimationFrame(draw);
  }

  #listen() {
    this.play?.addEventListener("click", () => this.#send({ type: this.phase === "running" ? "pause" : "play" }));
    const speed = this.document.getElementById("speed");
    speed?.addEventListener("change", () => this.#send({ type: "speed", times: Number(/** @type {HTMLSelectElement} */ (speed).value) }));
    this.seek?.addEventListener("change", () => this.#send({ type: "seek", tick: Number(this.seek?.value) }));
  }

  /** @param {object} message */
  #send(message) {
    this.connection.send(JSON.stringify(message));
  }

  /** @param {StaffText | import("./net/messages.js").BinaryMessage} message */
  #hear(message) {
    if (message.type === "snapshot" || message.type === "plan" || message.type === "display") this.spectator.take(message);
    else if (message.type === "welcome") this.spectator.begin(message);
    else if (message.type === "length") {
      if (this.seek) this.seek.max = String(message.ticks);
      if (!Number.isNaN(this.wanted_tick)) this.#send({ type: "seek", tick: this.wanted_tick });
      this.wanted_tick = NaN;
    } else if (message.type === "phase") this.#changePhase(message.phase);
    else if (message.type === "error") this.line.textContent = message.message;
  }

  /** @param {string} phase */
  #changePhase(phase) {
    this.phase = phase;
    this.spectator.setRunning(phase === "running");
    this.line.textContent = PHASES[phase] ?? phase;
    if (this.play) {
      this.play.textContent = phase === "running" ? "Pause" : "Play";
      this.play.setAttribute("aria-pressed", String(phase === "running"));
    }
  }

  /** @param {string} state @param {string} reason */
  #lineChanged(state, reason) {
    if (state !== "open") {
      this.spectator.setRunning(false);
      this.line.textContent = reason || (STATES[state] ?? "The server closed the line. Load the page again.");
    }
    this.stage.dataset.connection = state;
  }

  #showMoment() {
    const tick = Math.max(0, Math.floor(this.spectator.tick));
    this.tickField.value = String(tick);
    const text = `${(tick / TICK_HZ).toFixed(1)} s`;
    if (this.clock.textContent !== text) this.clock.textContent = text;
    if (this.seek && this.document.activeElement !== this.seek) this.seek.value = String(tick);
    Object.assign(this.stage.dataset, { tick: String(tick), phase: this.phase, frames: String(this.spectator.frames), camera: this.spectator.cameras?.mode ?? "" });
  }
}
