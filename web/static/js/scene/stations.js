// Drop stations and robots' homes: bays between low posts, signs on the wall and above, kerbs along
// the strips where nobody walks.

import { Color } from "three";
import { CHARGE_CELL, HAZARD_CELL, plateCell, signCell } from "./atlas.js";
import { STATION_COLOURS } from "./palette.js";
import { cellX, cellY } from "./space.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {import("./space.js").StationPlan} StationPlan */
/** @typedef {import("./builder.js").MeshBuilder} MeshBuilder */

const WHITE = new Color("#ffffff");
const STEEL = new Color("#5b666e");
const DARK = new Color("#2b3136");
const RAIL = new Color("#e2a91c");
const POST_M = 0.3;

/** A post between two bays: grey block, coloured cap. @param {MeshBuilder} builder @param {number[]} cell plan of its cell @param {Color} colour */
function addPost(builder, cell, colour) {
  const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] = cell;
  const inner = [x0 + 0.06, y0 + 0.06, x1 - 0.06, y1 - 0.06];
  builder.box(inner, 0, POST_M, STEEL);
  builder.box([x0 + 0.05, y0 + 0.05, x1 - 0.05, y1 - 0.05], POST_M, POST_M + 0.05, colour);
}

/** A guard rail along one side of a strip. @param {MeshBuilder} builder @param {number} a @param {number} b @param {(from: number, to: number, thick: number) => number[]} plan */
function addRail(builder, a, b, plan) {
  if (b - a < 0.3) return;
  const posts = Math.max(2, Math.ceil((b - a) / 1.5) + 1);
  for (let n = 0; n < posts; n += 1) {
    const at = a + 0.05 + ((b - a - 0.1) * n) / (posts - 1);
    builder.box(plan(at - 0.04, at + 0.04, 0.04), 0, 0.5, DARK);
  }
  builder.box(plan(a, b, 0.025), 0.2, 0.28, RAIL);
  builder.box(plan(a, b, 0.025), 0.4, 0.5, RAIL);
}

/** A board on a wall. @param {MeshBuilder} builder @param {number} x @param {number} y @param {number} size_m @param {number} low @param {boolean} facingUp plan direction the board looks to @param {import("./atlas.js").CellRect} picture */
function addBoard(builder, x, y, size_m, low, facingUp, picture) {
  const half = size_m / 2;
  const out = facingUp ? 1 : -1;
  builder.box([x - half - 0.04, Math.min(y, y + 0.05 * out), x + half + 0.04, Math.max(y, y + 0.05 * out)], low - 0.04, low + size_m + 0.04, DARK);
  const z = -(y + 0.056 * out);
  const left = facingUp ? x + half : x - half;
  const right = facingUp ? x - half : x + half;
  builder.panel([[left, low, z], [right, low, z], [right, low + size_m, z], [left, low + size_m, z]], WHITE, picture, { glow: 0.12 });
}

/** @param {MeshBuilder} builder @param {HallPlan} hall @param {StationPlan} station */
function addStation(builder, hall, station) {
  const colour = new Color(STATION_COLOURS[station.index % 4]);
  const atBottom = station.center_m[1] < hall.hall_height_m / 2;
  const [y0, y1] = atBottom ? [0, 0.6] : [hall.hall_height_m - 0.6, hall.hall_height_m];
  const wall = atBottom ? 0 : hall.hall_height_m;
  const columns = station.bays.map(([i]) => i).sort((a, b) => a - b);
  for (const i of columns) {
    const x = cellX(i);
    const back = atBottom ? [x - 0.28, 0.0, x + 0.28, 0.06] : [x - 0.28, wall - 0.06, x + 0.28, wall];
    builder.box(back, 0.06, 0.42, colour, { shade: 0.9 });
    if (columns.includes(i + 2)) addPost(builder, [x + 0.3, y0, x + 0.9, y1], colour);
  }
  const first = cellX(columns[0] ?? 0) - 0.3;
  const last = cellX(columns[columns.length - 1] ?? 0) + 0.3;
  for (const x of [first - 0.6, last]) addPost(builder, [x, y0, x + 0.6, y1], colour);
  const middle = (first + last) / 2;
  const band = atBottom ? [first - 0.3, 0.0, last + 0.3, 0.05] : [first - 0.3, wall - 0.05, last + 0.3, wall];
  builder.box(band, 1.22, 1.5, colour);
  addBoard(builder, middle, atBottom ? 0.05 : wall - 0.05, 1.5, 1.75, atBottom, signCell(station.index));
  addGantry(builder, first - 0.3, last + 0.3, atBottom ? 0.3 : wall - 0.3, colour, station.index);
}

/** A coloured gantry above the bays, seen over the racks. @param {MeshBuilder} builder @param {number} x0 @param {number} x1 @param {number} y @param {Color} colour @param {number} station */
function addGantry(builder, x0, x1, y, colour, station) {
  for (const x of [x0, x1]) builder.box([x - 0.05, y - 0.05, x + 0.05, y + 0.05], POST_M + 0.05, 3.5, STEEL);
  builder.box([x0 - 0.05, y - 0.06, x1 + 0.05, y + 0.06], 3.38, 3.62, colour);
  const x = (x0 + x1) / 2;
  const half = 0.42;
  for (const side of [1, -1]) {
    const z = -(y + side * 0.075);
    const left = x + side * half;
    const right = x - side * half;
    builder.panel([[left, 3.46, z], [right, 3.46, z], [right, 3.46 + 2 * half, z], [left, 3.46 + 2 * half, z]], WHITE, signCell(station), { glow: 0.12 });
  }
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
function addHomes(builder, hall) {
  const edge = hall.hall_width_m;
  hall.homes.forEach(([i, j], robot) => {
    const x = cellX(i) - 0.3;
    const y = cellY(j);
    builder.box([edge - 0.1, y - 0.2, edge, y + 0.2], 0, 0.3, DARK);
    const face = edge - 0.104;
    builder.panel([[face, 0.08, -(y + 0.1)], [face, 0.08, -(y - 0.1)], [face, 0.28, -(y - 0.1)], [face, 0.28, -(y + 0.1)]], WHITE, CHARGE_CELL, { glow: 0.25 });
    builder.box([edge - 0.03, y - 0.22, edge, y + 0.22], 0.62, 1.06, DARK);
    const board = edge - 0.035;
    builder.panel([[board, 0.65, -(y + 0.19)], [board, 0.65, -(y - 0.19)], [board, 1.03, -(y - 0.19)], [board, 1.03, -(y + 0.19)]], WHITE, plateCell(robot), { glow: 0.05 });
    for (const low of robot === 0 ? [y - 0.9, y + 0.3] : [y + 0.3]) addKerb(builder, x, low, low + 0.6);
  });
}

/** A low kerb with hazard stripes in front of a home's post. @param {MeshBuilder} builder @param {number} x @param {number} y0 @param {number} y1 */
function addKerb(builder, x, y0, y1) {
  builder.box([x + 0.06, y0 + 0.08, x + 0.56, y1 - 0.08], 0, 0.16, STEEL);
  const face = x + 0.055;
  builder.panel([[face, 0, -(y1 - 0.08)], [face, 0, -(y0 + 0.08)], [face, 0.16, -(y0 + 0.08)], [face, 0.16, -(y1 - 0.08)]], WHITE, HAZARD_CELL);
}

/** Rails where a strip is neither bay, post nor home. @param {MeshBuilder} builder @param {HallPlan} hall */
function addRails(builder, hall) {
  const { hall_width_m: w, hall_height_m: h } = hall;
  for (const [edge, bottom] of /** @type {[number, boolean][]} */ ([[0.57, true], [h - 0.57, false]])) {
    const spans = hall.stations
      .filter((station) => station.center_m[1] < h / 2 === bottom)
      .map((station) => station.bays.map(([i]) => cellX(i)))
      .map((xs) => /** @type {[number, number]} */ ([Math.min(...xs) - 0.9, Math.max(...xs) + 0.9]))
      .sort((a, b) => a[0] - b[0]);
    let from = 0;
    for (const [a, b] of [...spans, /** @type {[number, number]} */ ([w - 0.6, w])]) {
      addRail(builder, from, a, (p, q, t) => [p, edge - t, q, edge + t]);
      from = b;
    }
  }
  const ys = hall.homes.map(([, j]) => cellY(j));
  const edge = w - 0.57;
  const plan = (/** @type {number} */ p, /** @type {number} */ q, /** @type {number} */ t) => [edge - t, p, edge + t, q];
  addRail(builder, 0.6, Math.min(...ys) - 0.9, plan);
  addRail(builder, Math.max(...ys) + 0.9, h - 0.6, plan);
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
export function addStations(builder, hall) {
  for (const station of hall.stations) addStation(builder, hall, station);
  addHomes(builder, hall);
  addRails(builder, hall);
}
