// The running world as somebody sees it who only looks on: the picture, its cameras, and where
// everything is now. Brings together what any page of this kind needs.

import { CameraPointer } from "./input/camera_pointer.js";
import { HeldFlight } from "./input/flight.js";
import { TickClock } from "./net/clock.js";
import { EXTRAPOLATED_TICKS, SnapshotBuffer, turnBetween } from "./net/snapshots.js";
import { Cameras } from "./scene/cameras.js";
import { Marker } from "./scene/marker.js";
import { Person } from "./scene/person.js";
import { Stage } from "./scene/stage.js";
import { HallView } from "./scene/view.js";

/** @typedef {import("./net/messages.js").Welcome} Welcome */
/** @typedef {import("./net/messages.js").Snapshot} Snapshot */
/** @typedef {import("./scene/cameras.js").CameraMode} CameraMode */
/** @typedef {{ chosen: (agent: number) => void, cameraChanged: (mode: CameraMode) => void }} SpectatorHandlers */

/** Everything is drawn this far in the past: two snapshots at 15 Hz, less a little. */
const DELAY_MS = 120;
const TICK_HZ = 30;
const YAW_STEPS = 65536;
/** How near a click must be to a robot or a station's middle, pixels. */
const PICK_PX = 44;
/** From high up the human is drawn larger than it is. */
const PERSON_ABOVE = 1.7;
/** Held keys move the camera by no more than this much time per picture. */
const LONGEST_FRAME_S = 0.25;

/** Shows one trial after another in one picture. */
export class Spectator {
  /** @param {HTMLElement} element that the picture fills @param {"auto" | "on" | "off"} antialias @param {SpectatorHandlers} handlers */
  constructor(element, antialias, handlers) {
    this.element = element;
    this.handlers = handlers;
    this.stage = new Stage(element, antialias, () => {});
    new ResizeObserver(() => this.stage.resize()).observe(element);
    this.person = new Person();
    this.marker = new Marker();
    this.stage.scene.add(this.person.object, this.marker.object);
    this.snapshots = new SnapshotBuffer();
    this.flight = new HeldFlight();
    this.isRunning = false;
    this.pace = 1;
    this.frames = 0;
    this.last_ms = NaN;
    /** @type {number | null} agent with the marker */
    this.chosen = null;
    this.size = () => this.stage.size;
    new CameraPointer(this.stage.canvas, {
      turn: (dx, dy) => this.cameras?.turn(dx, dy, this.size()),
      pan: (dx, dy) => this.cameras?.pan(dx, dy, this.size()),
      zoom: (steps, x, y) => this.cameras?.zoom(steps, this.size(), { x, y }),
      tap: (x, y) => this.#pick(x, y),
    });
  }

  /** Shows the trial of a welcome; the hall is built once, as all trials of a run take place in it. @param {Welcome} welcome */
  begin(welcome) {
    if (!this.view) {
      const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
      this.view = new HallView(this.stage, { hall: welcome.hall, robots: welcome.robots, widestAt: welcome.settings.ribbon_widest_at, still });
      this.cameras = new Cameras(welcome.hall);
      this.#cameraChanged();
    }
    this.clock ??= new TickClock(TICK_HZ * welcome.time_scale * this.pace, DELAY_MS);
    for (let robot = 0; robot < welcome.robots; robot += 1) this.view.setPlan(robot, []);
    this.welcome = welcome;
    this.snapshots.clear();
    this.clock?.reset();
  }

  /** @param {import("./net/messages.js").BinaryMessage} message */
  take(message) {
    if (message.type === "plan") this.view?.setPlan(message.robot, message.corners);
    else if (message.type === "display") this.view?.setDisplay(message);
    else {
      this.snapshots.push(message);
      this.clock?.hear(message.tick, performance.now());
    }
  }

  /** @param {boolean} running whether ticks go on */
  setRunning(running) {
    if (running && !this.isRunning) this.clock?.reset();
    this.isRunning = running;
  }

  /** A replay is shown so many times as fast as it was. @param {number} times */
  setPace(times) {
    this.pace = times;
    this.clock = new TickClock(TICK_HZ * (this.welcome?.time_scale ?? 1) * times, DELAY_MS);
  }

  /** @param {CameraMode} mode */
  choose(mode) {
    this.cameras?.choose(mode);
    this.#cameraChanged();
  }

  chooseNext() {
    this.cameras?.chooseNext();
    this.#cameraChanged();
  }

  #cameraChanged() {
    if (this.view) this.view.numbersAll = this.cameras?.mode !== "worker";
    this.handlers.cameraChanged(this.cameras?.mode ?? "above");
  }

  /** Numbers on all robots, or only on those shown live. */
  toggleNumbers() {
    if (this.view) this.view.numbersAll = !this.view.numbersAll;
  }

  /** The tick that is on the screen now, fractional; hardly ever beyond the newest that was told. */
  get tick() {
    const newest = this.snapshots.newest;
    if (!newest) return this.welcome?.tick ?? 0;
    const tick = this.isRunning ? this.clock?.drawnTick(performance.now()) : newest.tick;
    return tick === undefined || Number.isNaN(tick) ? newest.tick : Math.min(tick, newest.tick + EXTRAPOLATED_TICKS);
  }

  /** The human between two snapshots. @param {number} tick */
  #humanAt(tick) {
    const { snapshots } = this.snapshots;
    let before = snapshots.length - 1;
    while (before > 0 && /** @type {Snapshot} */ (snapshots[before]).tick > tick) before -= 1;
    const a = snapshots[before]?.human ?? this.welcome?.human ?? { x_m: 0, y_m: 0, yaw: 0 };
    const b = snapshots[before + 1]?.human ?? a;
    const [from, to] = [snapshots[before]?.tick ?? 0, snapshots[before + 1]?.tick ?? 0];
    const t = to > from ? Math.max(0, Math.min(1, (tick - from) / (to - from))) : 0;
    const radians = (/** @type {number} */ yaw) => (yaw / YAW_STEPS) * 2 * Math.PI;
    const heading = radians(a.yaw) + turnBetween(radians(a.yaw), radians(b.yaw)) * t;
    return { x: a.x_m + (b.x_m - a.x_m) * t, y: a.y_m + (b.y_m - a.y_m) * t, heading };
  }

  /** Draws the world of now. @param {number} now_ms */
  draw(now_ms) {
    const { view, cameras } = this;
    if (!view || !cameras) return;
    const passed_ms = now_ms - this.last_ms || 0;
    this.last_ms = now_ms;
    this.stage.adapt(passed_ms);
    if (!this.flight.isIdle) cameras.fly(this.flight.motion(now_ms), Math.min(LONGEST_FRAME_S, passed_ms / 1000), this.size());
    const tick = this.tick;
    const human = this.#humanAt(tick);
    const robots = this.snapshots.sample(tick);
    const sight = cameras.sight(human, this.size());
    this.person.place(human, sight.outside, cameras.mode === "above" ? PERSON_ABOVE : 1);
    this.#mark(robots, sight.outside);
    view.draw(sight, robots, now_ms / 1000);
    this.frames += 1;
  }

  /** @param {{ x_m: number, y_m: number }[]} robots @param {boolean} outside */
  #mark(robots, outside) {
    const place = this.#placeOf(this.chosen ?? -1, robots);
    if (place && outside) this.marker.place(place, (this.chosen ?? 0) >= robots.length);
    else this.marker.hide();
  }

  /** @param {number} agent @param {{ x_m: number, y_m: number }[]} robots */
  #placeOf(agent, robots) {
    const robot = robots[agent];
    if (robot) return { x: robot.x_m, y: robot.y_m };
    const station = this.welcome?.hall.stations[agent - robots.length];
    return station && robots.length ? { x: station.center_m[0], y: station.center_m[1] } : null;
  }

  /** Chooses the agent under a click. @param {number} x_px @param {number} y_px */
  #pick(x_px, y_px) {
    const robots = this.snapshots.sample(this.tick);
    const agents = robots.length + (this.welcome?.hall.stations.length ?? 0);
    let [best, chosen] = [PICK_PX, -1];
    for (let agent = 0; agent < agents; agent += 1) {
      const place = this.#placeOf(agent, robots);
      const spot = place && this.stage.project(place.x, place.y, 0.3);
      const far = spot ? Math.hypot(spot.x - x_px, spot.y - y_px) : Infinity;
      if (far < best) [best, chosen] = [far, agent];
    }
    if (chosen >= 0) this.handlers.chosen(chosen);
  }
}
