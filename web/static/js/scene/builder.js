// Collects boxes, panels and turned shapes into one geometry, so that the whole standing hall is a
// single draw call. Vertices carry a colour, a place in the atlas and a glow.

import { BufferAttribute, BufferGeometry, Color, Vector3 } from "three";
import { WHITE_CELL } from "./atlas.js";

/** @typedef {import("./atlas.js").CellRect} CellRect */
/** @typedef {{ glow?: number, shade?: number }} Finish glow: light of its own; shade: factor on the colour */

const FACES = /** @type {[number[], number[][]][]} */ ([
  [[1, 0, 0], [[1, 0, 1], [1, 0, 0], [1, 1, 0], [1, 1, 1]]],
  [[-1, 0, 0], [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]]],
  [[0, 1, 0], [[0, 1, 1], [1, 1, 1], [1, 1, 0], [0, 1, 0]]],
  [[0, -1, 0], [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]],
  [[0, 0, 1], [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]],
  [[0, 0, -1], [[1, 0, 0], [0, 0, 0], [0, 1, 0], [1, 1, 0]]],
]);

/** Grows one indexed geometry; plan coordinates in, scene coordinates out. */
export class MeshBuilder {
  constructor() {
    /** @type {number[]} */ this.positions = [];
    /** @type {number[]} */ this.normals = [];
    /** @type {number[]} */ this.colours = [];
    /** @type {number[]} */ this.uvs = [];
    /** @type {number[]} */ this.glows = [];
    /** @type {number[]} */ this.indices = [];
  }

  /** @param {number[]} at scene x, y, z @param {number[]} normal @param {Color} colour @param {number} u @param {number} v @param {Finish} finish */
  #vertex(at, normal, colour, u, v, finish) {
    const shade = finish.shade ?? 1;
    this.positions.push(at[0] ?? 0, at[1] ?? 0, at[2] ?? 0);
    this.normals.push(normal[0] ?? 0, normal[1] ?? 0, normal[2] ?? 0);
    this.colours.push(colour.r * shade, colour.g * shade, colour.b * shade);
    this.uvs.push(u, v);
    this.glows.push(finish.glow ?? 0);
  }

  #close() {
    const n = this.positions.length / 3 - 4;
    this.indices.push(n, n + 1, n + 2, n, n + 2, n + 3);
  }

  /**
   * An upright box over a rectangle of the plan.
   * @param {number[]} plan x0, y0, x1, y1 in metres @param {number} low @param {number} high
   * @param {Color} colour @param {Finish} [finish]
   */
  box(plan, low, high, colour, finish = {}) {
    const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] = plan;
    for (const [normal, corners] of FACES) {
      for (const [cx = 0, cy = 0, cz = 0] of corners) {
        const at = [x0 + (x1 - x0) * cx, low + (high - low) * cy, -(y1 + (y0 - y1) * cz)];
        this.#vertex(at, normal, colour, WHITE_CELL.u, WHITE_CELL.v, finish);
      }
      this.#close();
    }
  }

  /**
   * A bar of square section between two points of the scene.
   * @param {Vector3} from @param {Vector3} to @param {number} thick_m @param {Color} colour
   */
  bar(from, to, thick_m, colour) {
    const along = to.clone().sub(from);
    const side = new Vector3(0, 1, 0).cross(along);
    if (side.lengthSq() < 1e-9) side.set(1, 0, 0);
    side.normalize().multiplyScalar(thick_m / 2);
    const up = along.clone().cross(side).normalize().multiplyScalar(thick_m / 2);
    const ring = [side.clone().add(up), up.clone().sub(side), side.clone().add(up).negate(), side.clone().sub(up)];
    for (let k = 0; k < 4; k += 1) {
      const a = /** @type {Vector3} */ (ring[k]);
      const b = /** @type {Vector3} */ (ring[(k + 1) % 4]);
      const normal = a.clone().add(b).normalize().toArray();
      for (const [end, offset] of /** @type {[Vector3, Vector3][]} */ ([[from, b], [from, a], [to, a], [to, b]]))
        this.#vertex(end.clone().add(offset).toArray(), normal, colour, WHITE_CELL.u, WHITE_CELL.v, {});
      this.#close();
    }
  }

  /**
   * A flat four-cornered panel, seen from the side from which its corners run anticlockwise.
   * @param {number[][]} corners scene x, y, z: lower left, lower right, upper right, upper left
   * @param {Color} colour @param {CellRect | null} picture of the atlas, or plain @param {Finish} [finish]
   */
  panel(corners, colour, picture, finish = {}) {
    const [a, b, , d] = corners.map((c) => new Vector3(c[0], c[1], c[2]));
    if (!a || !b || !d) return;
    const normal = b.sub(a).cross(d.sub(a)).normalize().toArray();
    const rect = picture ?? { u0: WHITE_CELL.u, v0: WHITE_CELL.v, u1: WHITE_CELL.u, v1: WHITE_CELL.v };
    const places = [[rect.u0, rect.v0], [rect.u1, rect.v0], [rect.u1, rect.v1], [rect.u0, rect.v1]];
    corners.forEach((corner, n) => this.#vertex(corner, normal, colour, places[n]?.[0] ?? 0, places[n]?.[1] ?? 0, finish));
    this.#close();
  }

  /** Adds a ready geometry as it stands (scene coordinates). @param {BufferGeometry} geometry @param {Color} colour @param {Finish} [finish] */
  shape(geometry, colour, finish = {}) {
    const position = geometry.getAttribute("position");
    const normal = geometry.getAttribute("normal");
    const first = this.positions.length / 3;
    for (let n = 0; n < position.count; n += 1)
      this.#vertex(
        [position.getX(n), position.getY(n), position.getZ(n)],
        [normal.getX(n), normal.getY(n), normal.getZ(n)],
        colour, WHITE_CELL.u, WHITE_CELL.v, finish,
      );
    const index = geometry.getIndex();
    const count = index ? index.count : position.count;
    for (let n = 0; n < count; n += 1) this.indices.push(first + (index ? index.getX(n) : n));
    geometry.dispose();
  }

  /** @returns {BufferGeometry} with position, normal, color, uv and glow */
  build() {
    const geometry = new BufferGeometry();
    const set = (/** @type {string} */ name, /** @type {number[]} */ values, /** @type {number} */ size) =>
      geometry.setAttribute(name, new BufferAttribute(new Float32Array(values), size));
    set("position", this.positions, 3);
    set("normal", this.normals, 3);
    set("color", this.colours, 3);
    set("uv", this.uvs, 2);
    set("glow", this.glows, 1);
    geometry.setIndex(new BufferAttribute(new Uint32Array(this.indices), 1));
    return geometry;
  }
}
