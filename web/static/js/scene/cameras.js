// Where a spectator looks from: through the worker's eyes, from above on the whole hall, or free.
// Numbers only; the plan's metres and radians, screen pixels y down.

/** @typedef {"worker" | "above" | "free"} CameraMode */
/** @typedef {{ x: number, y: number, heading: number }} Standpoint of the human */
/** @typedef {{ width: number, height: number }} Size pixels */
/**
 * @typedef {object} Sight everything the picture needs of a camera
 * @property {number} x @property {number} y @property {number} heading @property {number} pitch
 * @property {number} height_m @property {number} fov_deg vertically @property {number} near_m @property {number} far_m
 * @property {boolean} outside above the racks, not through the worker's eyes
 */

/** @type {readonly CameraMode[]} */
export const CAMERA_MODES = Object.freeze(["worker", "above", "free"]);

const WORKER_FOV_DEG = 60;
/** From above a narrow view from high up: nearly a plan, and nothing hides behind a rack. */
const ABOVE_FOV_DEG = 12;
const ABOVE_MARGIN = 1.09;
const ABOVE_ZOOM_MAX = 8;
/** A hall that fills the view this much better when turned by a quarter is turned. */
const TURN_GAIN = 1.25;
const FREE_FOV_DEG = 50;
const FREE_DISTANCE_M = /** @type {[number, number]} */ ([2, 120]);
const FREE_PITCH = /** @type {[number, number]} */ ([-1.5, -0.05]);
const FREE_LEAST_HEIGHT_M = 0.4;
const ZOOM_PER_STEP = 1.15;
const TURN_PER_PX = 0.005;
/** Keys: shares of the visible extent per second, and radians per second. */
const FLY_PER_S = 0.6;
const TURN_PER_S = 1.6;
const ZOOM_STEPS_PER_S = 6;

const tanHalf = (/** @type {number} */ deg) => Math.tan((deg * Math.PI) / 360);
const clamp = (/** @type {number} */ value, /** @type {readonly [number, number]} */ [low, high]) => Math.min(high, Math.max(low, value));

/** The three cameras of one hall; each keeps its place while another is used. */
export class Cameras {
  /** @param {{ hall_width_m: number, hall_height_m: number, eye_height_m: number }} hall */
  constructor(hall) {
    this.hall = hall;
    /** @type {CameraMode} */
    this.mode = "above";
    this.above = { x: 0, y: 0, zoom: 1 };
    this.free = { x: 0, y: 0, heading: 0, pitch: 0, distance_m: 0 };
    this.refit("above");
    this.refit("free");
  }

  /** @param {CameraMode} mode */
  choose(mode) {
    this.mode = mode;
  }

  /** @param {number} [by] steps */
  chooseNext(by = 1) {
    const at = CAMERA_MODES.indexOf(this.mode) + by + CAMERA_MODES.length;
    this.mode = /** @type {CameraMode} */ (CAMERA_MODES[at % CAMERA_MODES.length]);
  }

  /** Puts a camera where it sees the whole hall. @param {CameraMode} [mode] */
  refit(mode = this.mode) {
    const { hall_width_m: w, hall_height_m: h } = this.hall;
    if (mode === "above") this.above = { x: w / 2, y: h / 2, zoom: 1 };
    if (mode === "free") this.free = { x: w / 2, y: 0.42 * h, heading: Math.PI / 2, pitch: -0.78, distance_m: Math.max(10, 0.62 * Math.hypot(w, h)) };
  }

  /** Whether the plan's x axis runs up the screen from above. @param {Size} size */
  isTurned({ width, height }) {
    const { hall_width_m: w, hall_height_m: h } = this.hall;
    const scale = (/** @type {number} */ across, /** @type {number} */ up) => Math.min(width / across, height / up);
    return scale(h, w) > TURN_GAIN * scale(w, h);
  }

  /** Metres from the lower to the upper edge from above. @param {Size} size */
  spanAbove(size) {
    const { hall_width_m: w, hall_height_m: h } = this.hall;
    const [across, up] = this.isTurned(size) ? [h, w] : [w, h];
    return (Math.max(up, (across * size.height) / size.width) * ABOVE_MARGIN) / this.above.zoom;
  }

  /** @param {Standpoint} human @param {Size} size @returns {Sight} */
  sight(human, size) {
    if (this.mode === "above") return this.#sightAbove(size);
    if (this.mode === "free") return this.#sightFree();
    return {
      x: human.x, y: human.y, heading: human.heading, pitch: 0, height_m: this.hall.eye_height_m,
      fov_deg: WORKER_FOV_DEG, near_m: 0.1, far_m: 140, outside: false,
    };
  }

  /** @param {Size} size @returns {Sight} */
  #sightAbove(size) {
    const { x, y } = this.above;
    const height_m = this.spanAbove(size) / 2 / tanHalf(ABOVE_FOV_DEG);
    return {
      x, y, heading: this.isTurned(size) ? 0 : Math.PI / 2, pitch: -Math.PI / 2, height_m,
      fov_deg: ABOVE_FOV_DEG, near_m: Math.max(0.5, height_m - 12), far_m: height_m + 2, outside: true,
    };
  }

  /** @returns {Sight} */
  #sightFree() {
    const { x, y, heading, pitch, distance_m } = this.free;
    const back = Math.cos(pitch) * distance_m;
    return {
      x: x - Math.cos(heading) * back, y: y - Math.sin(heading) * back, heading, pitch,
      height_m: Math.max(FREE_LEAST_HEIGHT_M, -Math.sin(pitch) * distance_m),
      fov_deg: FREE_FOV_DEG, near_m: 0.1, far_m: 400, outside: true,
    };
  }

  /** Metres per pixel of whatever is panned. @param {Size} size */
  #perPixel(size) {
    return this.mode === "above" ? this.spanAbove(size) / size.height : (2 * this.free.distance_m * tanHalf(FREE_FOV_DEG)) / size.height;
  }

  /** Moves over the floor, in the directions of the view. @param {number} right_m @param {number} up_m @param {Size} size */
  #shift(right_m, up_m, size) {
    const heading = this.mode === "free" ? this.free.heading : this.isTurned(size) ? 0 : Math.PI / 2;
    const place = this.mode === "above" ? this.above : this.free;
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    place.x = clamp(place.x + c * up_m + s * right_m, [0, this.hall.hall_width_m]);
    place.y = clamp(place.y + s * up_m - c * right_m, [0, this.hall.hall_height_m]);
  }

  /** A drag that moves the hall along with the pointer. @param {number} dx_px @param {number} dy_px @param {Size} size */
  pan(dx_px, dy_px, size) {
    if (this.mode === "worker") return;
    const scale = this.#perPixel(size);
    const steep = this.mode === "free" ? Math.max(0.3, -Math.sin(this.free.pitch)) : 1;
    this.#shift(-dx_px * scale, (dy_px * scale) / steep, size);
  }

  /** A drag that turns the free camera round what it looks at; from above it moves the hall. @param {number} dx_px @param {number} dy_px @param {Size} size */
  turn(dx_px, dy_px, size) {
    if (this.mode !== "free") return this.pan(dx_px, dy_px, size);
    this.free.heading -= dx_px * TURN_PER_PX;
    this.free.pitch = clamp(this.free.pitch - dy_px * TURN_PER_PX, FREE_PITCH);
  }

  /**
   * Goes nearer to the point under the pointer, or to the middle without one.
   * @param {number} steps positive goes nearer @param {Size} size @param {{ x: number, y: number }} [at_px]
   */
  zoom(steps, size, at_px) {
    const factor = ZOOM_PER_STEP ** steps;
    if (this.mode === "free") this.free.distance_m = clamp(this.free.distance_m / factor, FREE_DISTANCE_M);
    if (this.mode !== "above") return;
    const before = this.spanAbove(size);
    this.above.zoom = clamp(this.above.zoom * factor, [1, ABOVE_ZOOM_MAX]);
    const moved = (before - this.spanAbove(size)) / size.height;
    if (at_px) this.#shift((at_px.x - size.width / 2) * moved, (size.height / 2 - at_px.y) * moved, size);
    if (this.above.zoom === 1) this.refit("above");
  }

  /** Held keys. @param {{ forward: number, right: number, turn: number, zoom: number }} motion -1, 0 or 1 each @param {number} seconds @param {Size} size */
  fly({ forward, right, turn, zoom }, seconds, size) {
    if (this.mode === "worker") return;
    const reach_m = this.#perPixel(size) * size.height * FLY_PER_S * seconds;
    if (forward || right) this.#shift(right * reach_m, forward * reach_m, size);
    if (turn && this.mode === "free") this.free.heading += turn * TURN_PER_S * seconds;
    if (zoom) this.zoom(zoom * ZOOM_STEPS_PER_S * seconds, size);
  }
}
