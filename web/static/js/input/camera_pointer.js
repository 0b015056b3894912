// Mouse, pen and wheel on the picture: what they ask the camera to do.

/**
 * @typedef {object} CameraWishes
 * @property {(dx_px: number, dy_px: number) => void} turn drag with the first button
 * @property {(dx_px: number, dy_px: number) => void} pan drag with another button, or with Shift
 * @property {(steps: number, x_px: number, y_px: number) => void} zoom wheel; positive goes nearer
 * @property {(x_px: number, y_px: number) => void} tap a click without a drag
 */

/** A pointer that moved less than this was not dragged. */
const TAP_PX = 4;
const WHEEL_STEP = 100;
/** Wheels that count in lines or pages instead of pixels. */
const WHEEL_UNITS = [1, 33, 400];

/** Listens to one surface. */
export class CameraPointer {
  /** @param {HTMLElement} surface @param {CameraWishes} wishes */
  constructor(surface, wishes) {
    this.surface = surface;
    this.wishes = wishes;
    /** @type {{ id: number, x: number, y: number, moved: number, pans: boolean } | null} */
    this.drag = null;
    surface.addEventListener("pointerdown", (event) => this.#down(event));
    surface.addEventListener("pointermove", (event) => this.#move(event));
    for (const name of /** @type {const} */ (["pointerup", "pointercancel"]))
      surface.addEventListener(name, (event) => this.#up(event));
    surface.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    surface.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (this.drag) return;
    this.drag = { id: event.pointerId, x: event.clientX, y: event.clientY, moved: 0, pans: event.button !== 0 || event.shiftKey };
    this.surface.setPointerCapture(event.pointerId);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const { drag } = this;
    if (!drag || event.pointerId !== drag.id) return;
    const [dx, dy] = [event.clientX - drag.x, event.clientY - drag.y];
    drag.moved += Math.hypot(dx, dy);
    [drag.x, drag.y] = [event.clientX, event.clientY];
    if (drag.moved < TAP_PX) return;
    if (drag.pans) this.wishes.pan(dx, dy);
    else this.wishes.turn(dx, dy);
  }

  /** @param {PointerEvent} event */
  #up(event) {
    const { drag } = this;
    if (!drag || event.pointerId !== drag.id) return;
    this.drag = null;
    if (event.type === "pointerup" && drag.moved < TAP_PX && !drag.pans) this.wishes.tap(...this.#place(event));
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const pixels = event.deltaY * (WHEEL_UNITS[event.deltaMode] ?? 1);
    this.wishes.zoom(-pixels / WHEEL_STEP, ...this.#place(event));
  }

  /** @param {MouseEvent} event @returns {[number, number]} pixels from the surface's corner */
  #place(event) {
    const box = this.surface.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
}
