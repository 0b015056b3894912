// A trial as this page lives it: connection, own human, picture and notes, wired together.

import { Controls } from "./controls.js";
import { FrameAccumulator } from "./input/accumulator.js";
import { Prediction } from "./input/prediction.js";
import { TickClock } from "./net/clock.js";
import { Connection, PARTICIPANT_PROTOCOL } from "./net/connection.js";
import { encodeAttention, encodeContext, encodeInput, encodeQuality, encodeReady, INPUT_FRAMES_MAX } from "./net/messages.js";
import { SnapshotBuffer } from "./net/snapshots.js";
import { QualityWatch } from "./quality.js";
import { Stage } from "./scene/stage.js";
import { HallView } from "./scene/view.js";
import { Beacon } from "./ui/beacon.js";
import { Hud } from "./ui/hud.js";
import { Overlays } from "./ui/overlays.js";

/** @typedef {import("./net/messages.js").Welcome} Welcome */
/** @typedef {import("./net/messages.js").Phase} Phase */
/** @typedef {import("./net/messages.js").Snapshot} Snapshot */
/** @typedef {{ live: string, next: string, antialias: "auto" | "on" | "off" }} Addresses */

/** Robots are drawn this far in the past: two snapshots at 15 Hz, less a little. */
const DELAY_MS = 120;
const PUMP_EVERY_MS = 16;
const TICK_HZ = 30;

/** One page's part in a trial. */
export class Trial {
  /** @param {HTMLElement} element #stage @param {Addresses} addresses */
  constructor(element, addresses) {
    this.window = /** @type {Window} */ (element.ownerDocument.defaultView);
    this.addresses = addresses;
    this.overlays = new Overlays(element);
    this.overlays.show("loading");
    this.stage = new Stage(element, addresses.antialias, (lost) => this.#contextChanged(lost));
    this.controls = new Controls(this.stage.canvas, {
      help: () => this.#toggleHelp(),
      attention: (visible, focused, locked) => this.#attentionChanged(visible, focused, locked),
      keysChanging: () => this.#keepPictureSteady(),
      lockRefused: () => this.overlays.explainTurning(),
    });
    this.hud = new Hud(element, () => this.#toggleHelp());
    this.beacon = new Beacon(element);
    this.snapshots = new SnapshotBuffer();
    this.quality = new QualityWatch();
    this.phase = "waiting";
    this.connectionName = "lost";
    this.delivered = 0;
    this.frames = 0;
    this.countdownEnd_ms = 0;
    this.lastFrame_ms = NaN;
    this.isReadySent = false;
    /** @type {number[][]} places of the robots for the own human's collisions */
    this.robotPlaces = [];
    /** @type {{ keys: number, yaw: number }} the held keys as last drawn */
    this.drawnFrame = { keys: 0, yaw: 0 };
    this.connection = new Connection(addresses.live, {
      message: (message) => this.#hear(message),
      state: (state) => this.#connectionChanged(state),
    }, PARTICIPANT_PROTOCOL);
    this.window.setInterval(() => this.#pump(performance.now()), PUMP_EVERY_MS);
    this.window.requestAnimationFrame((now_ms) => this.#drawFrame(now_ms));
  }

  /** @param {import("./net/connection.js").Message} message */
  #hear(message) {
    if (message.type === "snapshot") this.#takeSnapshot(message);
    else if (message.type === "plan") this.view?.setPlan(message.robot, message.corners);
    else if (message.type === "display") this.view?.setDisplay(message);
    else if (message.type === "phase") this.#changePhase(message);
    else if (message.type === "welcome") this.#begin(message);
    else if (message.type === "delivered") this.#showDelivered(message.boxes);
    else if (message.type === "pong") this.quality.roundTrip(this.connection.roundTrip_ms);
    else if (message.type === "finished") this.#leave(message.next);
  }

  /** @param {Welcome} welcome */
  #begin(welcome) {
    if (this.welcome && this.welcome.trial_id !== welcome.trial_id) return this.#leave(this.addresses.next);
    if (!this.view) {
      const still = this.window.matchMedia("(prefers-reduced-motion: reduce)").matches;
      const widestAt = welcome.settings.ribbon_widest_at;
      this.view = new HallView(this.stage, { hall: welcome.hall, robots: welcome.robots, widestAt, still });
      this.prediction = new Prediction(welcome.hall, welcome.human, welcome.acknowledged_seq);
      this.controls.look.setYaw(welcome.human.yaw);
      const rate = TICK_HZ * welcome.time_scale;
      this.accumulator = new FrameAccumulator(rate);
      this.clock = new TickClock(rate, DELAY_MS);
    } else this.prediction?.restart(welcome.human, welcome.acknowledged_seq);
    for (let robot = 0; robot < welcome.robots; robot += 1) this.view.setPlan(robot, []);
    this.welcome = welcome;
    this.snapshots.clear();
    this.clock?.reset();
    this.accumulator?.stop();
    this.isReadySent = false;
    this.hud.begin(welcome.label, welcome.boxes_total);
    this.#showDelivered(welcome.boxes_delivered);
    this.controls.reportAgain();
  }

  /** @param {Phase} message */
  #changePhase(message) {
    const wasRunning = this.phase === "running";
    this.phase = message.phase;
    const now_ms = performance.now();
    if (message.phase === "running") {
      if (!wasRunning) {
        this.clock?.reset();
        this.accumulator?.start(now_ms);
      }
    } else {
      this.accumulator?.stop();
      if (wasRunning && this.prediction) this.prediction.dropPending(this.snapshots.newest?.human ?? this.prediction);
    }
    if (message.acknowledged_seq !== undefined && this.prediction && !wasRunning) this.prediction.seq = message.acknowledged_seq;
    this.countdownEnd_ms = now_ms + (message.seconds ?? 0) * 1000;
    this.beacon.announce(this.phase, this.connectionName);
  }

  /** @param {Snapshot} snapshot */
  #takeSnapshot(snapshot) {
    this.snapshots.push(snapshot);
    this.clock?.hear(snapshot.tick, performance.now());
    this.robotPlaces = snapshot.robots.map((robot) => [robot.x_m, robot.y_m]);
    this.prediction?.reconcile(snapshot.acknowledged, snapshot.human, this.robotPlaces);
  }

  /** @param {number} boxes */
  #showDelivered(boxes) {
    this.delivered = boxes;
    this.hud.showBoxes(boxes);
  }

  /** Makes and sends the input frames that are due. @param {number} now_ms */
  #pump(now_ms) {
    if (this.connection.state !== "open" || this.phase !== "running" || !this.prediction || !this.accumulator) return;
    this.controls.turn(now_ms);
    const report = this.quality.takeReport(now_ms);
    if (report) this.connection.send(encodeQuality(report));
    const due = this.accumulator.advance(now_ms);
    const { look, held } = this.controls;
    for (let first = 0; first < due; first += INPUT_FRAMES_MAX) {
      const frames = Array.from({ length: Math.min(INPUT_FRAMES_MAX, due - first) }, () => ({ keys: held.bits, yaw: look.yaw }));
      const firstSeq = this.prediction.seq + 1;
      for (const frame of frames) this.prediction.apply(frame, this.robotPlaces);
      this.connection.send(encodeInput(firstSeq, frames));
    }
  }

  /** The human as drawn now. */
  #humanNow() {
    if (!this.prediction) return { x_m: 0, y_m: 0 };
    const frame = { keys: this.controls.held.bits, yaw: this.controls.look.yaw };
    const fraction = this.phase === "running" ? (this.accumulator?.fraction ?? 0) : 0;
    return this.prediction.drawn(frame, fraction, this.robotPlaces);
  }

  /** When keys change within a frame, what was drawn of it fades instead of jumping. */
  #keepPictureSteady() {
    if (!this.prediction || !this.accumulator?.isRunning) return;
    this.#pump(performance.now());
    const before = this.#humanNow();
    queueMicrotask(() => this.prediction?.absorb(before, this.#humanNow()));
  }

  /** @param {number} now_ms */
  #drawFrame(now_ms) {
    this.window.requestAnimationFrame((next_ms) => this.#drawFrame(next_ms));
    this.#pump(performance.now());
    this.#showState(now_ms);
    const { view, welcome } = this;
    if (!view || !welcome) return;
    const passed_ms = now_ms - this.lastFrame_ms || 0;
    this.lastFrame_ms = now_ms;
    this.prediction?.fade(passed_ms / 1000);
    this.stage.adapt(passed_ms);
    if (this.phase === "running" && this.controls.isVisible) this.quality.frame(now_ms);
    else this.quality.interrupt();
    const human = this.#humanNow();
    const { look } = this.controls;
    const viewpoint = { x: human.x_m, y: human.y_m, heading: look.heading, pitch: look.pitch };
    view.draw(viewpoint, this.#robotsNow(), now_ms / 1000);
    this.frames += 1;
    this.#reportReady();
    this.beacon.write(now_ms, () => this.#facts());
  }

  #robotsNow() {
    const newest = this.snapshots.newest;
    if (!newest) return [];
    const tick = this.phase === "running" ? this.clock?.drawnTick(performance.now()) : newest.tick;
    return this.snapshots.sample(tick === undefined || Number.isNaN(tick) ? newest.tick : tick);
  }

  /** Tells the server that the hall is on the screen, once per connection and only when it is seen. */
  #reportReady() {
    if (this.isReadySent || !this.controls.isVisible || this.stage.lost || !this.snapshots.newest) return;
    this.isReadySent = this.connection.send(encodeReady());
  }

  #facts() {
    const newest = this.snapshots.newest;
    const { x_m, y_m } = this.prediction ?? { x_m: 0, y_m: 0 };
    return {
      phase: this.phase, connection: this.connectionName, tick: newest?.tick ?? this.welcome?.tick ?? 0,
      x_m, y_m, yaw: this.controls.look.yaw, delivered: this.delivered, frames: this.frames, robots: newest?.robots ?? [],
    };
  }

  /** Chooses the note that fits the moment. @param {number} now_ms */
  #showState(now_ms) {
    const { overlays, phase, connection } = this;
    const running = phase === "running" && connection.state === "open" && !this.stage.lost;
    this.controls.setEnabled((running || phase === "countdown") && !overlays.isHelpOpen);
    overlays.showHint((running || phase === "countdown") && !this.controls.pointer.isLocked && !overlays.isHelpOpen);
    this.hud.showLine(connection.state === "open", connection.roundTrip_ms);
    this.hud.showTime((this.snapshots.newest?.tick ?? this.welcome?.tick ?? 0) / TICK_HZ);
    if (phase === "finished") overlays.show("finished");
    else if (connection.state === "taken-over" || connection.state === "refused") overlays.show(connection.state);
    else if (!this.welcome) overlays.show(connection.state === "lost" ? "lost" : "loading");
    else if (connection.state !== "open") overlays.show("lost");
    else if (this.stage.lost) overlays.show("context-lost");
    else if (phase === "countdown") overlays.showCountdown((this.countdownEnd_ms - now_ms) / 1000);
    else if (phase === "running") overlays.hide();
    else overlays.show(phase === "paused" ? "paused" : "waiting");
  }

  #toggleHelp() {
    this.overlays.toggleHelp();
    if (this.overlays.isHelpOpen) this.controls.pointer.release();
    this.#showState(performance.now());
  }

  /** @param {boolean} visible @param {boolean} focused @param {boolean} locked */
  #attentionChanged(visible, focused, locked) {
    if (!visible) this.quality?.interrupt();
    this.connection?.send(encodeAttention(visible, focused, locked));
  }

  /** @param {boolean} lost */
  #contextChanged(lost) {
    this.connection?.send(encodeContext(lost));
  }

  /** @param {import("./net/connection.js").ConnectionState} state */
  #connectionChanged(state) {
    this.connectionName = state === "open" ? "open" : state === "taken-over" ? "taken-over" : "lost";
    if (state !== "open") this.accumulator?.stop();
    if (state === "lost" && this.phase === "running") this.phase = "paused";
    if (state === "reload") this.#leave(this.addresses.next);
    this.beacon.announce(this.phase, this.connectionName);
  }

  /** Opens the next page, which the server chooses. @param {string} address path on this server */
  #leave(address) {
    this.connection.finish();
    const { location } = this.window;
    const target = new URL(address, location.href);
    location.assign(target.origin === location.origin ? target.href : this.addresses.next);
  }
}
