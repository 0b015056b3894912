// The shape of a robot: two driven wheels under a round base, three plates on posts, a camera bar,
// a ring in the robot's colour and number plates all around. Origin on the floor, front along +x.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, Color, CylinderGeometry, LatheGeometry, Matrix4, Vector2,
} from "three";
import { CARRIED_M, ROBOT_TOP_M } from "./space.js";

/** What a part is painted with: its own colour, the robot's colour, the robot's number plate, or the face of the carried box. */
const OWN = 0;
const TEAM = 1;
const PLATE = 2;
const BOX = 3;

/** @typedef {{ positions: number[], normals: number[], colours: number[], uvs: number[], paints: number[], indices: number[] }} Parts */

/** @param {Parts} parts @param {BufferGeometry} geometry @param {string} hex @param {number} paint */
function add(parts, geometry, hex, paint) {
  const first = parts.positions.length / 3;
  const colour = new Color(hex);
  const position = geometry.getAttribute("position");
  const normal = geometry.getAttribute("normal");
  const uv = geometry.getAttribute("uv");
  for (let n = 0; n < position.count; n += 1) {
    const low = Math.min(1, Math.max(0, position.getY(n) / 0.12));
    const shade = 0.6 + 0.4 * low;
    parts.positions.push(position.getX(n), position.getY(n), position.getZ(n));
    parts.normals.push(normal.getX(n), normal.getY(n), normal.getZ(n));
    parts.colours.push(colour.r * shade, colour.g * shade, colour.b * shade);
    parts.uvs.push(uv.getX(n), uv.getY(n));
    parts.paints.push(paint);
  }
  const index = geometry.getIndex();
  const count = index ? index.count : position.count;
  for (let n = 0; n < count; n += 1) parts.indices.push(first + (index ? index.getX(n) : n));
  geometry.dispose();
}

/** @param {number} radius @param {number} low @param {number} high @param {number} [sides] */
function disc(radius, low, high, sides = 28) {
  return new CylinderGeometry(radius, radius, high - low, sides).translate(0, (low + high) / 2, 0);
}

/** A slightly bent number plate at an angle round the body. @param {number} angle */
function plate(angle) {
  const geometry = new CylinderGeometry(0.178, 0.178, 0.128, 4, 1, true, Math.PI / 2 - 0.4, 0.8);
  return geometry.applyMatrix4(new Matrix4().makeRotationY(angle)).translate(0, 0.318, 0);
}

/** @param {Parts} parts */
function addBase(parts) {
  const profile = [[0.1, 0.022], [0.168, 0.026], [0.178, 0.05], [0.178, 0.085], [0.15, 0.118], [0, 0.118]];
  add(parts, new LatheGeometry(profile.map(([x, y]) => new Vector2(x, y)), 32), "#2a2d31", OWN);
  add(parts, new CylinderGeometry(0.1815, 0.1815, 0.03, 32, 1, true).translate(0, 0.068, 0), "#ffffff", TEAM);
  for (const side of [-1, 1]) {
    const wheel = new CylinderGeometry(0.04, 0.04, 0.024, 16).rotateX(Math.PI / 2);
    add(parts, wheel.translate(0, 0.04, side * 0.125), "#111214", OWN);
  }
  add(parts, new BoxGeometry(0.03, 0.03, 0.2).translate(0.165, 0.052, 0), "#15171a", OWN);
}

/** @param {Parts} parts */
function addTower(parts) {
  for (const height of [0.15, 0.235]) add(parts, disc(0.158, height, height + 0.012), "#40464d", OWN);
  add(parts, disc(0.172, ROBOT_TOP_M - 0.024, ROBOT_TOP_M), "#40464d", OWN);
  add(parts, new CylinderGeometry(0.1735, 0.1735, 0.016, 32, 1, true).translate(0, ROBOT_TOP_M - 0.012, 0), "#ffffff", TEAM);
  for (const [x, z] of [[0.1, 0.1], [-0.1, 0.1], [0.1, -0.1], [-0.1, -0.1]])
    add(parts, new CylinderGeometry(0.009, 0.009, 0.3, 8).translate(x ?? 0, 0.265, z ?? 0), "#c9ced3", OWN);
  add(parts, new CylinderGeometry(0.052, 0.056, 0.05, 20).translate(0, 0.187, 0), "#191b1e", OWN);
  add(parts, new BoxGeometry(0.036, 0.034, 0.16).translate(0.125, 0.182, 0), "#191b1e", OWN);
  for (const z of [-0.045, 0.0, 0.045])
    add(parts, new CylinderGeometry(0.01, 0.01, 0.006, 10).rotateZ(Math.PI / 2).translate(0.145, 0.182, z), "#5fd0ff", OWN);
  add(parts, disc(0.152, 0.25, 0.385, 24), "#33383e", OWN);
  for (let n = 0; n < 4; n += 1) add(parts, plate((n * Math.PI) / 2), "#ffffff", PLATE);
}

/** The number seen from above when nothing is carried. @param {Parts} parts */
function addTopPlate(parts) {
  const top = new CylinderGeometry(0.12, 0.12, 0.004, 28).translate(0, ROBOT_TOP_M + 0.003, 0);
  const uv = top.getAttribute("uv");
  const position = top.getAttribute("position");
  for (let n = 0; n < uv.count; n += 1) {
    const x = position.getX(n) / 0.24;
    const z = position.getZ(n) / 0.24;
    uv.setXY(n, 0.5 + z, 0.5 + x);
  }
  add(parts, top, "#ffffff", PLATE);
}

/** The box on top, which the shader draws only for robots that carry one. @param {Parts} parts */
function addLoad(parts) {
  const box = new BoxGeometry(CARRIED_M, CARRIED_M, CARRIED_M).rotateY(Math.PI / 2);
  add(parts, box.translate(0, ROBOT_TOP_M + 0.006 + CARRIED_M / 2, 0), "#ffffff", BOX);
}

/** @returns {BufferGeometry} with position, normal, uv, base (own colour) and paint */
export function makeRobotShape() {
  /** @type {Parts} */
  const parts = { positions: [], normals: [], colours: [], uvs: [], paints: [], indices: [] };
  addBase(parts);
  addTower(parts);
  addTopPlate(parts);
  addLoad(parts);
  const geometry = new BufferGeometry();
  const set = (/** @type {string} */ name, /** @type {number[]} */ values, /** @type {number} */ size) =>
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(values), size));
  set("position", parts.positions, 3);
  set("normal", parts.normals, 3);
  set("uv", parts.uvs, 2);
  set("base", parts.colours, 3);
  set("paint", parts.paints, 1);
  geometry.setIndex(parts.indices);
  return geometry;
}

/** The robot as a closed bell without inner faces, for avatars and ghosts. @returns {BufferGeometry} */
export function makeBellShape() {
  const profile = [[0, 0.01], [0.165, 0.01], [0.19, 0.035], [0.19, 0.1], [0.18, 0.128], [0.164, 0.136], [0.164, 0.24], [0.17, 0.244], [0.17, 0.256], [0.164, 0.26], [0.164, 0.366], [0.18, 0.374], [0.184, 0.4], [0.178, 0.425], [0.162, 0.436], [0, 0.44]];
  const shape = new LatheGeometry(profile.map(([x, y]) => new Vector2(x, y)), 28);
  shape.deleteAttribute("uv");
  return shape;
}
