// One trial as staff watch it: picture, cameras, the moment shown, and a replay's controls.

import { Connection } from "./net/connection.js";
import { decodeText, encodeHello } from "./net/messages.js";
import { CAMERA_MODES } from "./scene/cameras.js";
import { Spectator } from "./spectator.js";
import { CameraBar } from "./ui/camera_bar.js";
import { Notices } from "./ui/notices.js";
import { MomentForm, QuietForm } from "./watch_forms.js";
import { listenToWatchKeys } from "./watch_keys.js";

/** @typedef {import("./net/messages.js").TextMessage | { type: "length", ticks: number }} StaffText */
/** @typedef {import("./scene/cameras.js").CameraMode} CameraMode */
/** @typedef {{ live: string, replay: string, isReplay: boolean, antialias: "auto" | "on" | "off" }} Addresses */

const TICK_HZ = 30;
const SLOW_MS = 300;
const SAID_MS = 5000;
const PHASES = /** @type {Record<string, string>} */ ({
  waiting: "Waiting for the participant", countdown: "About to start", running: "Running", paused: "Paused", finished: "Over",
});
/** What is said in the picture itself while nothing moves in a live trial. */
const NOTES = /** @type {Record<string, string>} */ ({
  waiting: "Waiting for the participant", countdown: "About to start", paused: "Paused: the participant is away",
});
const HINTS = { above: "Drag moves, wheel zooms, a click marks a robot" };

/** @param {string} text @returns {StaffText} */
function decode(text) {
  const message = JSON.parse(text);
  return message?.type === "length" && Number.isInteger(message.ticks) ? message : decodeText(text);
}

/** @param {number} tick */
const inSeconds = (tick) => `${(tick / TICK_HZ).toFixed(1)} s`;
/** @param {string} text */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** The page of one watched trial. */
export class WatchedTrial {
  /** @param {Document} document @param {Addresses} addresses */
  constructor(document, addresses) {
    this.addresses = addresses;
    const place = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
    this.stage = place("stage");
    this.line = place("line");
    this.clock = place("clock");
    this.boxes = place("boxes");
    this.notices = new Notices(place("notices"));
    this.seek = /** @type {HTMLInputElement | null} */ (document.getElementById("seek"));
    this.speed = /** @type {HTMLSelectElement | null} */ (document.getElementById("speed"));
    this.play = document.getElementById("play");
    this.phase = "";
    this.last = 0;
    this.isSeeking = false;
    this.isFresh = true;
    this.wasPlaying = false;
    this.wanted_tick = Number(/^#tick=(\d{1,9})$/.exec(location.hash)?.[1] ?? NaN);
    const cameras = new CameraBar(place("cameras"), CAMERA_MODES, {
      choose: (mode) => this.spectator.choose(/** @type {CameraMode} */ (mode)),
      refit: () => this.spectator.cameras?.refit(),
      numbers: () => this.spectator.toggleNumbers(),
    }, HINTS);
    this.spectator = new Spectator(this.stage, addresses.antialias, {
      chosen: (agent) => {
        this.spectator.chosen = agent === this.spectator.chosen ? null : agent;
      },
      cameraChanged: (mode) => cameras.show(mode),
    });
    this.notices.showNote("Connecting …");
    this.connection = new Connection(
      addresses.live,
      { message: (message) => this.#hear(message), state: (state, reason) => this.#lineChanged(state, reason) },
      { hello: encodeHello, decode, greeting: "welcome" },
    );
    this.#listen(document);
    const draw = (/** @type {number} */ now_ms) => {
      requestAnimationFrame(draw);
      this.spectator.draw(now_ms);
      this.notices.tick(now_ms);
      this.#showMoment();
    };
    requestAnimationFrame(draw);
  }

  /** The tick on the screen. */
  get tick() {
    return Math.max(0, Math.floor(this.spectator.tick));
  }

  /** @param {Document} document */
  #listen(document) {
    const say = (/** @type {string} */ text, /** @type {boolean} */ isRefusal) => this.notices.say(text, isRefusal, SAID_MS);
    const note = document.getElementById("note-form");
    if (note instanceof HTMLFormElement) this.moment = new MomentForm(note, () => this.tick, inSeconds, say);
    this.extend = document.getElementById("extend-form");
    if (this.extend instanceof HTMLFormElement) new QuietForm(this.extend, (sent) => say(`Waits ${sent.get("minutes")} minutes longer, should the participant be away`, false), say);
    listenToWatchKeys(document, this);
    this.play?.addEventListener("click", () => this.togglePlay());
    const { seek, speed } = this;
    if (speed) {
      speed.value = "1"; // some browsers bring a former choice back
      speed.addEventListener("change", () => this.#choosePace());
    }
    seek?.addEventListener("input", () => {
      this.isSeeking = true;
      this.#showClock(Number(seek.value));
    });
    seek?.addEventListener("change", () => this.seekTo(Number(seek.value)));
  }

  togglePlay() {
    if (this.addresses.isReplay) this.#send({ type: this.phase === "running" ? "pause" : "play" });
  }

  /** @param {number} tick */
  seekTo(tick) {
    this.isSeeking = false;
    if (this.addresses.isReplay) this.#send({ type: "seek", tick: Math.max(0, Math.min(this.last, Math.round(tick))) });
  }

  #choosePace() {
    const times = Number(this.speed?.value ?? 1);
    this.#send({ type: "speed", times });
    this.spectator.setPace(times);
  }

  /** @param {object} message */
  #send(message) {
    this.connection.send(JSON.stringify(message));
  }

  /** @param {StaffText | import("./net/messages.js").BinaryMessage} message */
  #hear(message) {
    if (message.type === "snapshot" || message.type === "plan" || message.type === "display") this.spectator.take(message);
    else if (message.type === "welcome") this.#begin(message);
    else if (message.type === "length") {
      this.last = message.ticks;
      if (this.seek) this.seek.max = String(message.ticks);
    } else if (message.type === "delivered") this.#showBoxes(message.boxes);
    else if (message.type === "phase") this.#changePhase(message.phase);
  }

  /** @param {import("./net/messages.js").Welcome} welcome */
  #begin(welcome) {
    this.boxes_total = welcome.boxes_total;
    this.spectator.begin(welcome);
    this.#showBoxes(welcome.boxes_delivered);
    if (!this.isFresh) return;
    this.isFresh = false;
    if (!this.addresses.isReplay) return;
    // A line that was lost begins the replay anew: go back to where it was.
    if (this.speed?.value !== "1") this.#choosePace();
    if (!Number.isNaN(this.wanted_tick)) this.seekTo(this.wanted_tick);
    this.wanted_tick = NaN;
    if (this.wasPlaying) this.#send({ type: "play" });
  }

  /** @param {number} boxes */
  #showBoxes(boxes) {
    this.boxes.textContent = `${boxes} of ${this.boxes_total ?? 0} boxes`;
  }

  /** @param {string} phase */
  #changePhase(phase) {
    const { isReplay } = this.addresses;
    this.phase = phase;
    this.spectator.setRunning(phase === "running");
    this.line.textContent = PHASES[phase] ?? phase;
    this.notices.showNote(isReplay ? "" : (NOTES[phase] ?? ""));
    if (phase === "finished" && !isReplay) this.#showEnd("This trial is over");
    if (this.play) this.play.textContent = phase === "running" ? "Pause" : "Play";
  }

  /** @param {string} title */
  #showEnd(title) {
    if (this.extend) this.extend.hidden = true;
    const links = this.addresses.isReplay ? [] : [{ text: "Watch the replay", address: this.addresses.replay }];
    this.notices.showBanner("ended", title, [], links);
  }

  /** @param {import("./net/connection.js").ConnectionState} state @param {string} reason */
  #lineChanged(state, reason) {
    this.stage.dataset.connection = state;
    if (state === "open") {
      this.notices.hideBanner();
      return;
    }
    if (state === "lost" && !this.isFresh) {
      this.wanted_tick = this.tick;
      this.wasPlaying = this.phase === "running";
    }
    this.isFresh = true;
    this.spectator.setRunning(false);
    if (state === "connecting") return;
    this.notices.showNote("");
    this.line.textContent = state === "lost" ? "Not connected" : "Ended";
    if (state === "lost" && reason) this.notices.showBanner("waiting", capital(reason), ["This page tries again by itself, and goes on as soon as it can."]);
    else if (state === "lost") this.notices.showBanner("lost", "Connection lost", ["What you see is old. Trying again …"]);
    else if (state === "reload") this.#showEnd(capital(reason));
    else this.notices.showBanner("refused", capital(reason) || "The server closed the line", ["Load the page again, or sign in again."], [{ text: "Sign in", address: "/login" }]);
  }

  /** @param {number} tick */
  #showClock(tick) {
    const text = this.addresses.isReplay ? `${inSeconds(tick)} of ${inSeconds(this.last)}` : inSeconds(tick);
    if (this.clock.textContent === text) return;
    this.clock.textContent = text;
    this.seek?.setAttribute("aria-valuetext", text);
  }

  #showMoment() {
    const { tick, seek, connection } = this;
    this.moment?.show();
    if (!this.isSeeking) {
      this.#showClock(tick);
      if (seek) seek.value = String(tick);
    }
    const quality = connection.state !== "open" ? "lost" : connection.roundTrip_ms > SLOW_MS ? "slow" : "good";
    if (this.line.dataset.quality !== quality) this.line.dataset.quality = quality;
    Object.assign(this.stage.dataset, { tick: String(tick), phase: this.phase, frames: String(this.spectator.frames), camera: this.spectator.cameras?.mode ?? "" });
  }
}
