// What breaks up the walls: a band of high windows all around, seams of the cladding, and roller doors
// on the wall where neither stations nor homes are.

import { Color } from "three";
import { HAZARD_CELL } from "./atlas.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {import("./builder.js").MeshBuilder} MeshBuilder */
/** @typedef {(along: number, out: number) => [number, number]} Wall plan point `along` metres along a wall, `out` metres into the hall */

const FRAME = new Color("#6f7c86");
const GLASS = new Color("#dcecf6");
const SEAM = new Color("#c3c9cc");
const DOOR = new Color("#c9ced2");
const SLAT = new Color("#aab2b8");
const WHITE = new Color("#ffffff");
const BUFFER = new Color("#23282c");

/** As much of the stripes as fits a jamb 0.18 m wide and 0.5 m high, unstretched. */
const JAMB_STRIPES = { ...HAZARD_CELL, u1: HAZARD_CELL.u0 + 0.09 * (HAZARD_CELL.u1 - HAZARD_CELL.u0) };

const WINDOW_M = /** @type {[number, number]} */ ([3.75, 4.55]);
const BAY_M = 6;
const DOOR_M = { width: 2.8, height: 3.0, slats: 10 };

/** The four walls and their lengths. @param {HallPlan} hall @returns {{ wall: Wall, length: number, isFree: boolean }[]} */
function listWalls(hall) {
  const { hall_width_m: w, hall_height_m: h } = hall;
  return [
    { wall: (a, out) => [w - a, out], length: w, isFree: false },
    { wall: (a, out) => [w - out, h - a], length: h, isFree: false },
    { wall: (a, out) => [a, h - out], length: w, isFree: false },
    { wall: (a, out) => [out, a], length: h, isFree: true },
  ];
}

/** A flat panel on a wall. @param {MeshBuilder} builder @param {Wall} wall @param {number[]} box from, to, low, high @param {number} out @param {Color} colour @param {{ picture?: import("./atlas.js").CellRect, glow?: number, shade?: number }} [look] */
function hang(builder, wall, [from = 0, to = 0, low = 0, high = 0], out, colour, look = {}) {
  const [ax, ay] = wall(from, out);
  const [bx, by] = wall(to, out);
  builder.panel([[ax, low, -ay], [bx, low, -by], [bx, high, -by], [ax, high, -ay]], colour, look.picture ?? null, look);
}

/** @param {MeshBuilder} builder @param {Wall} wall @param {number} length */
function addWindows(builder, wall, length) {
  const bays = Math.max(2, Math.round(length / BAY_M));
  const [low, high] = WINDOW_M;
  for (let bay = 0; bay < bays; bay += 1) {
    const from = (bay * length) / bays + 0.55;
    const to = ((bay + 1) * length) / bays - 0.55;
    hang(builder, wall, [from - 0.07, to + 0.07, low - 0.07, high + 0.07], 0.012, FRAME);
    const panes = Math.max(2, Math.round((to - from) / 1.2));
    for (let pane = 0; pane < panes; pane += 1) {
      const a = from + ((to - from) * pane) / panes + 0.03;
      const b = from + ((to - from) * (pane + 1)) / panes - 0.03;
      hang(builder, wall, [a, b, low, high], 0.026, GLASS, { glow: 0.55 });
    }
    for (let seam = 1; seam < 3; seam += 1) {
      const at = from - 0.55 + (seam * (to - from + 1.1)) / 3;
      hang(builder, wall, [at - 0.02, at + 0.02, 1.2, low - 0.07], 0.012, SEAM, { shade: 0.86 });
    }
  }
}

/** A closed roller door with striped jambs. @param {MeshBuilder} builder @param {Wall} wall @param {number} middle */
function addDoor(builder, wall, middle) {
  const { width, height, slats } = DOOR_M;
  const [from, to] = [middle - width / 2, middle + width / 2];
  hang(builder, wall, [from - 0.22, to + 0.22, 0, height + 0.32], 0.018, FRAME, { shade: 0.75 });
  for (const [a, b] of [[from - 0.2, from - 0.02], [to + 0.02, to + 0.2]])
    for (let n = 0; n < 3; n += 1)
      hang(builder, wall, [a ?? 0, b ?? 0, n * 0.5, n * 0.5 + 0.5], 0.03, WHITE, { picture: JAMB_STRIPES });
  for (let n = 0; n < slats; n += 1) {
    const low = (n * height) / slats;
    const high = ((n + 1) * height) / slats;
    hang(builder, wall, [from, to, low, high - 0.03], 0.03, DOOR, { shade: n % 2 ? 0.97 : 1 });
    hang(builder, wall, [from, to, high - 0.03, high], 0.03, SLAT, { shade: 0.8 });
  }
  const pane = (height * 5) / slats;
  for (let n = 0; n < 3; n += 1) {
    const at = from + 0.4 + (n * (width - 0.8)) / 3;
    hang(builder, wall, [at, at + (width - 0.8) / 3 - 0.08, pane + 0.06, pane + height / slats - 0.06], 0.04, GLASS, { glow: 0.4 });
  }
  for (const at of [from + 0.1, to - 0.4]) hang(builder, wall, [at, at + 0.3, 0.02, 0.32], 0.045, BUFFER);
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
export function addWallFeatures(builder, hall) {
  for (const { wall, length, isFree } of listWalls(hall)) {
    addWindows(builder, wall, length);
    if (!isFree) continue;
    const bays = Math.max(2, Math.round(length / BAY_M));
    for (let bay = 0; bay < bays; bay += 1) addDoor(builder, wall, ((bay + 0.5) * length) / bays);
  }
}
