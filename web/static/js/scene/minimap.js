// The round map at the lower left: heading up, the human in the middle with the view's wedge, robots
// as numbered dots. Robots beyond its rim sit on the rim, smaller.

import { inkOn, robotColour, STATION_COLOURS } from "./palette.js";
import { cellX, cellY } from "./space.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {import("./space.js").RobotSample} RobotSample */
/** @typedef {CanvasRenderingContext2D} Pen */

const RANGE_M = 13;
const FONT = "system-ui, 'Segoe UI', 'DejaVu Sans', Arial, sans-serif";

/** The hall from above, drawn once. @param {Document} document @param {HallPlan} hall @param {number} scale pixels per metre */
function drawPlan(document, hall, scale) {
  const canvas = document.createElement("canvas");
  canvas.width = Math.ceil(hall.hall_width_m * scale);
  canvas.height = Math.ceil(hall.hall_height_m * scale);
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  pen.scale(scale, scale);
  pen.fillStyle = "#36424d";
  pen.fillRect(0, 0, hall.hall_width_m, hall.hall_height_m);
  pen.fillStyle = "#8796a3";
  for (const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] of hall.shelves_m)
    pen.fillRect(x0, hall.hall_height_m - y1, x1 - x0, y1 - y0);
  for (const station of hall.stations) {
    pen.fillStyle = STATION_COLOURS[station.index % 4] ?? "#888888";
    for (const [i, j] of station.bays) pen.fillRect(cellX(i) - 0.3, hall.hall_height_m - cellY(j) - 0.3, 0.6, 0.6);
  }
  pen.fillStyle = "#5b6873";
  for (const [i, j] of hall.homes) pen.fillRect(cellX(i) - 0.25, hall.hall_height_m - cellY(j) - 0.25, 0.5, 0.5);
  return canvas;
}

/** @param {Document} document @param {number} robot @param {number} size_px @returns {HTMLCanvasElement} */
function drawDot(document, robot, size_px) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size_px;
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  const middle = size_px / 2;
  for (const [radius, colour] of /** @type {[number, string][]} */ ([[0.5, "rgba(10, 14, 20, 0.55)"], [0.46, "#ffffff"], [0.38, robotColour(robot)]])) {
    pen.fillStyle = colour;
    pen.beginPath();
    pen.arc(middle, middle, size_px * radius, 0, 7);
    pen.fill();
  }
  pen.fillStyle = inkOn(robotColour(robot));
  pen.font = `800 ${size_px * (robot < 9 ? 0.56 : 0.47)}px ${FONT}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(String(robot + 1), middle, middle + size_px * 0.03);
  return canvas;
}

/** The minimap on a canvas of its own. */
export class Minimap {
  /** @param {HTMLElement} parent @param {HallPlan} hall @param {number} robots @param {number} size_px CSS pixels across */
  constructor(parent, hall, robots, size_px) {
    const { ownerDocument: document } = parent;
    this.hall = hall;
    this.size_px = size_px;
    this.ratio = Math.min(2, document.defaultView?.devicePixelRatio ?? 1);
    this.canvas = document.createElement("canvas");
    this.canvas.className = "minimap";
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Map of the hall around you");
    this.canvas.width = this.canvas.height = Math.round(size_px * this.ratio);
    this.canvas.style.width = this.canvas.style.height = `${size_px}px`;
    this.canvas.hidden = true;
    parent.append(this.canvas);
    this.pen = /** @type {Pen} */ (this.canvas.getContext("2d"));
    this.scale = ((size_px / 2 - 5) * this.ratio) / RANGE_M;
    this.plan = drawPlan(document, hall, this.scale);
    this.dots = Array.from({ length: robots }, (_, robot) => drawDot(document, robot, Math.round(22 * this.ratio)));
  }

  /** @param {boolean} shown */
  show(shown) {
    this.canvas.hidden = !shown;
  }

  /** Its place on the screen, for what must keep clear of it. @param {number} height_px of the view */
  disc(height_px) {
    return this.canvas.hidden ? null : { x: 20 + this.size_px / 2, y: height_px - 20 - this.size_px / 2, radius: this.size_px / 2 };
  }

  /** @param {{ x: number, y: number, heading: number, halfView: number }} eye @param {RobotSample[]} robots */
  draw(eye, robots) {
    if (this.canvas.hidden) return;
    const { pen, scale } = this;
    const middle = this.canvas.width / 2;
    const radius = RANGE_M * scale;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, 2 * middle, 2 * middle);
    pen.save();
    pen.beginPath();
    pen.arc(middle, middle, radius, 0, 7);
    pen.fillStyle = "#161d24";
    pen.fill();
    pen.clip();
    pen.translate(middle, middle);
    pen.rotate(eye.heading - Math.PI / 2);
    pen.drawImage(this.plan, -eye.x * scale, -(this.hall.hall_height_m - eye.y) * scale);
    pen.restore();
    this.#drawWedge(middle, radius, eye.halfView);
    for (let robot = robots.length - 1; robot >= 0; robot -= 1) {
      const sample = robots[robot];
      if (sample) this.#drawRobot(middle, radius, eye, robot, sample);
    }
    this.#drawRim(middle, radius);
  }

  /** @param {number} middle @param {number} radius @param {number} halfView */
  #drawWedge(middle, radius, halfView) {
    const { pen } = this;
    const shade = pen.createRadialGradient(middle, middle, 0, middle, middle, radius);
    shade.addColorStop(0, "rgba(255, 255, 255, 0.5)");
    shade.addColorStop(1, "rgba(255, 255, 255, 0.06)");
    pen.fillStyle = shade;
    pen.beginPath();
    pen.moveTo(middle, middle);
    pen.arc(middle, middle, radius, -Math.PI / 2 - halfView, -Math.PI / 2 + halfView);
    pen.fill();
  }

  /** @param {number} middle @param {number} radius @param {{ x: number, y: number, heading: number }} eye @param {number} robot @param {RobotSample} sample */
  #drawRobot(middle, radius, eye, robot, sample) {
    const dx = sample.x_m - eye.x;
    const dy = sample.y_m - eye.y;
    const far = Math.hypot(dx, dy) * this.scale;
    const angle = Math.atan2(dy, dx) - eye.heading + Math.PI / 2;
    const reach = Math.min(far, radius - 6 * this.ratio);
    const dot = /** @type {HTMLCanvasElement} */ (this.dots[robot]);
    const size = dot.width * (far > radius ? 0.78 : 1);
    this.pen.globalAlpha = far > radius ? 0.85 : 1;
    const x = middle + Math.cos(angle) * reach;
    const y = middle - Math.sin(angle) * reach;
    this.pen.drawImage(dot, x - size / 2, y - size / 2, size, size);
    this.pen.globalAlpha = 1;
  }

  /** @param {number} middle @param {number} radius */
  #drawRim(middle, radius) {
    const { pen } = this;
    pen.lineWidth = 3 * this.ratio;
    pen.strokeStyle = "rgba(255, 255, 255, 0.85)";
    pen.beginPath();
    pen.arc(middle, middle, radius + this.ratio, 0, 7);
    pen.stroke();
    const tip = 7 * this.ratio;
    pen.fillStyle = "#ffffff";
    pen.strokeStyle = "rgba(10, 14, 20, 0.7)";
    pen.lineWidth = 1.5 * this.ratio;
    pen.beginPath();
    pen.moveTo(middle, middle - tip * 1.25);
    pen.lineTo(middle + tip * 0.85, middle + tip);
    pen.lineTo(middle, middle + tip * 0.45);
    pen.lineTo(middle - tip * 0.85, middle + tip);
    pen.closePath();
    pen.fill();
    pen.stroke();
  }
}
