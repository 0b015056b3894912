// Walls and columns of the hall, and above them ceiling, trusses and light panels.

import { Color, Vector3 } from "three";
import { PANEL_HALF_M, PANEL_PITCH_M } from "./light.js";
import { CEILING_M, cellY } from "./space.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {import("./builder.js").MeshBuilder} MeshBuilder */

const DADO = new Color("#5d6b76");
const STRIPE = new Color("#e2a91c");
const WALL = new Color("#dfe3e4");
const FASCIA = new Color("#b9c1c6");
const COLUMN = new Color("#8b99a3");
const ROOF = new Color("#9aa4ab");
const STEEL = new Color("#8b979f");
const LAMP = new Color("#ffffff");
const HOUSING = new Color("#5a646c");

/** Bands of a wall from the floor up: top edge, colour, shade. */
const BANDS = /** @type {[number, Color, number][]} */ ([
  [0.25, DADO, 0.72], [1.1, DADO, 0.95], [1.2, STRIPE, 1], [2.4, WALL, 0.97], [4.3, WALL, 1.02], [CEILING_M, FASCIA, 0.85],
]);

/** @param {MeshBuilder} builder @param {[number, number]} a @param {[number, number]} b plan; the hall lies left of a -> b */
function addWall(builder, a, b) {
  let low = 0;
  for (const [high, colour, shade] of BANDS) {
    const corners = [[a[0], low, -a[1]], [b[0], low, -b[1]], [b[0], high, -b[1]], [a[0], high, -a[1]]];
    builder.panel([corners[1] ?? [], corners[0] ?? [], corners[3] ?? [], corners[2] ?? []], colour, null, { shade });
    low = high;
  }
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
function addColumns(builder, hall) {
  const { hall_width_m: w, hall_height_m: h } = hall;
  const along = (/** @type {number} */ length) => {
    const bays = Math.max(2, Math.round(length / 6));
    return Array.from({ length: bays + 1 }, (_, n) => Math.min(length - 0.12, Math.max(0.12, (n * length) / bays)));
  };
  const nearBoard = (/** @type {number} */ x) => hall.stations.some(({ center_m }) => Math.abs(center_m[0] - x) < 1);
  const nearHome = (/** @type {number} */ y) => hall.homes.some(([, j]) => Math.abs(cellY(j) - y) < 0.4);
  for (const x of along(w).filter((at) => !nearBoard(at)))
    for (const y of [0.06, h - 0.06]) builder.box([x - 0.12, y - 0.06, x + 0.12, y + 0.06], 0, CEILING_M, COLUMN);
  for (const y of along(h).slice(1, -1))
    for (const x of nearHome(y) ? [0.06] : [0.06, w - 0.06]) builder.box([x - 0.06, y - 0.12, x + 0.06, y + 0.12], 0, CEILING_M, COLUMN);
}

/** @param {MeshBuilder} builder @param {number} y @param {number} width_m */
function addTruss(builder, y, width_m) {
  const low = CEILING_M - 0.62;
  const high = CEILING_M - 0.08;
  builder.box([0, y - 0.05, width_m, y + 0.05], low - 0.05, low + 0.05, STEEL);
  builder.box([0, y - 0.05, width_m, y + 0.05], high - 0.05, high + 0.05, STEEL);
  const fields = Math.max(2, Math.round(width_m / 1.4));
  for (let n = 0; n < fields; n += 1) {
    const x0 = (n * width_m) / fields;
    const x1 = ((n + 1) * width_m) / fields;
    const from = new Vector3(x0, n % 2 ? high : low, -y);
    builder.bar(from, new Vector3(x1, n % 2 ? low : high, -y), 0.055, STEEL);
  }
}

/** Places of the light panels; the floor's mirror uses the same rule. @param {number} length @param {number} pitch */
function panelPlaces(length, pitch) {
  const count = Math.floor(length / pitch);
  const margin = (length - pitch * count) / 2;
  return Array.from({ length: count }, (_, n) => margin + pitch * (n + 0.5));
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
export function addCeiling(builder, hall) {
  const { hall_width_m: w, hall_height_m: h } = hall;
  const y = CEILING_M;
  builder.panel([[0, y, -h], [w, y, -h], [w, y, 0], [0, y, 0]], ROOF, null, { glow: 0.5 });
  const spans = Math.max(2, Math.round(h / 5.4));
  for (let n = 1; n < spans; n += 1) addTruss(builder, (n * h) / spans, w);
  const [px, py] = PANEL_HALF_M;
  const low = CEILING_M - 0.3;
  for (const cx of panelPlaces(w, PANEL_PITCH_M[0]))
    for (const cy of panelPlaces(h, PANEL_PITCH_M[1])) {
      builder.box([cx - px - 0.03, cy - py - 0.03, cx + px + 0.03, cy + py + 0.03], low, low + 0.08, HOUSING);
      const [x0, x1, z0, z1] = [cx - px, cx + px, -cy - py, -cy + py];
      const under = low - 0.004;
      builder.panel([[x0, under, z0], [x1, under, z0], [x1, under, z1], [x0, under, z1]], LAMP, null, { glow: 1.4 });
    }
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
export function addShell(builder, hall) {
  const { hall_width_m: w, hall_height_m: h } = hall;
  addWall(builder, [0, 0], [w, 0]);
  addWall(builder, [w, 0], [w, h]);
  addWall(builder, [w, h], [0, h]);
  addWall(builder, [0, h], [0, 0]);
  addColumns(builder, hall);
}
