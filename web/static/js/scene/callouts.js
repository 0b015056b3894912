// What is written over the picture: number labels of robots shown through the racks, names under the
// balloons, arrows at the edge for robots outside the view.

import { Vector3 } from "three";
import { edgeSpot, isInView, makeRoom, spreadBearings, wrapAngle } from "./arrow_layout.js";
import { arrowCell, balloonLabelCell, pillCell } from "./atlas.js";
import { layOutLabels } from "./label_layout.js";
import { ROBOT_TOP_M } from "./space.js";

/** @typedef {import("./sprites.js").Sprites} Sprites */
/** @typedef {import("./space.js").RobotSample} RobotSample */
/**
 * @typedef {object} Eye plan metres, radians, pixels
 * @property {number} x @property {number} y @property {number} heading @property {number} halfView
 * @property {number} width @property {number} height
 * @property {boolean} isOutside a spectator's camera
 * @property {number} steepness 0 looking straight ahead, 1 straight down
 * @property {number} widening field of view against the participant's, as a ratio of tangents
 */
/** @typedef {import("./arrow_layout.js").Disc} Disc */

/** How a robot's number is written: as participants see it, for spectators, and of robots not shown live. */
export const NORMAL = Object.freeze({ size: 1, alpha: 1 });
export const OUTSIDE = Object.freeze({ size: 0.85, alpha: 1 });
export const FAINT = Object.freeze({ size: 0.62, alpha: 0.72 });

const PILL_NEAR_PX = 44;
const PILL_FAR_PX = 32;
const ARROW_PX = 40;
const ARROW_INSET_PX = 54;
const ARROW_GAP = 0.16;
/** A station's name stays below the line of facts at the upper edge. */
const LABEL_TOP_PX = 84;
/** Spectators' cameras see stations from far away: smaller names. */
const OUTSIDE_LABEL = 0.68;
/** Share of the way to a label's new place made per second. */
const FOLLOW = 9;

/** Labels and arrows of a trial; remembers where labels were, so that they glide. */
export class Callouts {
  /** @param {Sprites} sprites @param {number} robots */
  constructor(sprites, robots) {
    this.sprites = sprites;
    this.shifts = new Float32Array(robots + 8);
    this.alphas = new Float32Array(robots + 8);
    this.point = new Vector3();
    /** Labels of this frame; one without a cell only keeps its place free. @type {{ id: number, cell: import("./atlas.js").CellRect | null, label: import("./label_layout.js").Label, strength: number }[]} */
    this.labels = [];
  }

  begin() {
    this.labels.length = 0;
  }

  /** @param {import("three").Camera} camera @param {Eye} eye @param {number} x @param {number} y @param {number} height_m @returns {{ x: number, y: number, depth_m: number } | null} */
  #project(camera, eye, x, y, height_m) {
    this.point.set(x, height_m, -y).applyMatrix4(camera.matrixWorldInverse);
    const depth_m = -this.point.z;
    if (depth_m < 0.3) return null;
    this.point.applyMatrix4(camera.projectionMatrix);
    const spot = { x: (this.point.x * 0.5 + 0.5) * eye.width, y: (0.5 - this.point.y * 0.5) * eye.height, depth_m };
    const away = Math.abs(this.point.x) > 1.05 || Math.abs(this.point.y) > 1.1;
    return away ? null : spot;
  }

  /** @param {import("three").Camera} camera @param {Eye} eye @param {number} robot @param {RobotSample} sample @param {{ size: number, alpha: number }} style */
  addRobot(camera, eye, robot, sample, style) {
    const top = ROBOT_TOP_M + (sample.carrying >= 0 ? 0.3 : 0);
    const spot = this.#project(camera, eye, sample.x_m, sample.y_m, top);
    if (!spot) return;
    const size = style.size * (PILL_FAR_PX + (PILL_NEAR_PX - PILL_FAR_PX) * Math.max(0, 1 - spot.depth_m / 14));
    const y = Math.max(eye.isOutside ? size / 2 : -Infinity, spot.y - size * 0.55);
    const label = { x: spot.x, y, w: size * 0.84, h: size * 0.84, depth_m: spot.depth_m };
    this.labels.push({ id: robot, cell: pillCell(robot), label, strength: style.alpha });
  }

  /** @param {import("three").Camera} camera @param {Eye} eye @param {number} station @param {{ x: number, y: number, height_m: number, size: number }} place @param {number} id */
  addBalloon(camera, eye, station, place, id) {
    const spot = this.#project(camera, eye, place.x, place.y, place.height_m - 0.78 * place.size);
    if (!spot) return;
    const across = (place.size * eye.height) / spot.depth_m / eye.widening;
    const below = 18 + 0.45 * across * eye.steepness;
    const small = eye.isOutside ? OUTSIDE_LABEL : 1;
    const [top, bottom] = eye.isOutside ? [18, eye.height - 18] : [LABEL_TOP_PX, Infinity];
    const half = eye.isOutside ? 36 : -Infinity;
    const x = Math.max(half, Math.min(eye.width - half, spot.x));
    const label = { x, y: Math.min(bottom, Math.max(top, spot.y + small * below)), w: 104 * small, h: 44 * small, depth_m: spot.depth_m - 100 };
    this.labels.push({ id, cell: balloonLabelCell(station), label, strength: 1 });
    this.labels.push({ id, cell: null, strength: 1, label: { x: spot.x, y: spot.y - 6 - across * 0.5, w: across, h: across, depth_m: -200 } });
  }

  /** Puts the collected labels on the screen. @param {number} seconds since the last frame */
  drawLabels(seconds) {
    const placements = layOutLabels(this.labels.map(({ label }) => label));
    const share = Math.min(1, seconds * FOLLOW);
    const order = this.labels.map((_, n) => n).sort((a, b) => (this.labels[b]?.label.depth_m ?? 0) - (this.labels[a]?.label.depth_m ?? 0));
    for (const n of order) {
      const { id, cell, label, strength } = /** @type {(typeof this.labels)[0]} */ (this.labels[n]);
      if (!cell) continue;
      const placement = placements[n] ?? { dy: 0, alpha: 1 };
      const shift = (this.shifts[id] ?? 0) + (placement.dy - (this.shifts[id] ?? 0)) * share;
      const alpha = (this.alphas[id] ?? 0) + (placement.alpha - (this.alphas[id] ?? 0)) * share;
      this.shifts[id] = shift;
      this.alphas[id] = alpha;
      const wide = label.w > label.h * 1.5;
      const size = wide ? { w: label.w * 1.077, h: label.h * 1.273 } : { w: label.w / 0.84, h: label.h / 0.84 };
      this.sprites.add(cell, label.x, label.y + shift, size.w, size.h, { alpha: alpha * strength });
    }
  }

  /** @param {Eye} eye @param {RobotSample[]} robots @param {Disc | null} keepOut the minimap's place */
  drawArrows(eye, robots, keepOut) {
    const frame = { width: eye.width, height: eye.height, inset: ARROW_INSET_PX };
    /** @type {{ robot: number, bearing: number }[]} */
    const outside = [];
    robots.forEach((sample, robot) => {
      const bearing = wrapAngle(eye.heading - Math.atan2(sample.y_m - eye.y, sample.x_m - eye.x));
      if (!isInView(bearing, eye.halfView)) outside.push({ robot, bearing });
    });
    const spread = spreadBearings(outside.map(({ bearing }) => bearing), ARROW_GAP);
    const spots = spread.map((bearing) => edgeSpot(bearing, frame));
    if (keepOut) makeRoom(spots, frame, keepOut, ARROW_PX);
    outside.forEach(({ robot }, n) => {
      const spot = /** @type {import("./arrow_layout.js").EdgeSpot} */ (spots[n]);
      const [dx, dy] = [Math.cos(spot.angle), Math.sin(spot.angle)];
      this.sprites.add(arrowCell(robot), spot.x + dx * 27, spot.y + dy * 27, ARROW_PX, ARROW_PX, { turn: spot.angle });
      this.sprites.add(pillCell(robot), spot.x, spot.y, ARROW_PX, ARROW_PX, {});
    });
  }
}
