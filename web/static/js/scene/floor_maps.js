// What is computed once for a hall's floor: the paint (three masks), the soft shade under and beside
// the racks, and a tile of concrete.

import { cellX, cellY, seededRandom } from "./space.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {CanvasRenderingContext2D} Pen */

const YELLOW = "#ff0000";
const WHITE = "#00ff00";
const STATION = "#0000ff";
const FONT = "system-ui, 'Segoe UI', 'DejaVu Sans', Arial, sans-serif";

/** @param {Pen} pen @param {string} text @param {number} x @param {number} y plan metres @param {number} size_m @param {number} turn clockwise radians @param {HallPlan} hall */
function writeOnFloor(pen, text, x, y, size_m, turn, hall) {
  pen.save();
  pen.translate(x, hall.hall_height_m - y);
  pen.rotate(turn);
  pen.scale(0.01, 0.01);
  pen.font = `800 ${size_m * 100}px ${FONT}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(text, 0, size_m * 5);
  pen.restore();
}

/** @param {Pen} pen @param {HallPlan} hall */
function paintRackZones(pen, hall) {
  pen.strokeStyle = YELLOW;
  pen.lineWidth = 0.06;
  for (const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] of hall.shelves_m) {
    pen.beginPath();
    pen.roundRect(x0 - 0.13, hall.hall_height_m - y1 - 0.13, x1 - x0 + 0.26, y1 - y0 + 0.26, 0.06);
    pen.stroke();
  }
}

/** White lines along the outer walkway. @param {Pen} pen @param {HallPlan} hall */
function paintWalkway(pen, hall) {
  const xs = hall.shelves_m.flatMap(([x0 = 0, , x1 = 0]) => [x0, x1]);
  const ys = hall.shelves_m.flatMap(([, y0 = 0, , y1 = 0]) => [y0, y1]);
  const gap = 0.62;
  const left = Math.min(...xs) - gap;
  const low = Math.min(...ys) - gap;
  const wide = Math.max(...xs) + gap - left;
  const tall = Math.max(...ys) + gap - low;
  pen.strokeStyle = WHITE;
  pen.lineWidth = 0.07;
  pen.setLineDash([0.6, 0.4]);
  pen.strokeRect(left, hall.hall_height_m - low - tall, wide, tall);
  pen.setLineDash([]);
}

/** @param {Pen} pen @param {HallPlan} hall */
function paintStations(pen, hall) {
  for (const station of hall.stations) {
    const atBottom = station.center_m[1] < hall.hall_height_m / 2;
    const wall_y = atBottom ? 0.6 : hall.hall_height_m - 0.6;
    const inward = atBottom ? 1 : -1;
    const xs = station.bays.map(([i]) => cellX(i));
    const x0 = Math.min(...xs) - 0.3;
    const x1 = Math.max(...xs) + 0.3;
    const top = (/** @type {number} */ a, /** @type {number} */ b) => hall.hall_height_m - Math.max(a, b);
    pen.fillStyle = STATION;
    for (const x of xs) pen.fillRect(x - 0.3, top(wall_y, wall_y - 0.6 * inward), 0.6, 0.6);
    pen.strokeStyle = STATION;
    pen.lineWidth = 0.1;
    pen.strokeRect(x0 - 0.05, top(wall_y, wall_y + 1.5 * inward), x1 - x0 + 0.1, 1.5);
    pen.fillStyle = WHITE;
    for (const x of xs) pen.fillRect(x - 0.22, top(wall_y - 0.04, wall_y + 0.04), 0.44, 0.08);
    pen.fillStyle = STATION;
    const turn = atBottom ? Math.PI : 0;
    writeOnFloor(pen, String(station.index + 1), (x0 + x1) / 2, wall_y + 0.78 * inward, 1.15, turn, hall);
  }
}

/** @param {Pen} pen @param {HallPlan} hall */
function paintHomes(pen, hall) {
  hall.homes.forEach(([i, j], robot) => {
    const x = cellX(i) - 0.3;
    const y = hall.hall_height_m - cellY(j);
    pen.strokeStyle = WHITE;
    pen.lineWidth = 0.05;
    pen.strokeRect(x + 0.03, y - 0.27, 0.54, 0.54);
    pen.fillStyle = WHITE;
    writeOnFloor(pen, String(robot + 1), x - 0.32, cellY(j), 0.42, Math.PI / 2, hall);
  });
}

/**
 * The floor's paint: red channel yellow paint, green channel white paint, blue channel station paint.
 * @param {Document} document @param {HallPlan} hall @param {number} longSide_px
 */
export function drawPaint(document, hall, longSide_px) {
  const scale = longSide_px / Math.max(hall.hall_width_m, hall.hall_height_m);
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(hall.hall_width_m * scale);
  canvas.height = Math.round(hall.hall_height_m * scale);
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  pen.fillStyle = "#000000";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.scale(canvas.width / hall.hall_width_m, canvas.height / hall.hall_height_m);
  paintRackZones(pen, hall);
  paintWalkway(pen, hall);
  paintStations(pen, hall);
  paintHomes(pen, hall);
  return canvas;
}

/** One pass of a sliding mean along one axis. @param {Float32Array} from @param {Float32Array} to @param {number} lines @param {number} length @param {number} lineStep @param {number} step @param {number} radius */
function blurLines(from, to, lines, length, lineStep, step, radius) {
  for (let line = 0; line < lines; line += 1) {
    const start = line * lineStep;
    let sum = 0;
    for (let n = -radius; n < length; n += 1) {
      const enter = n + radius;
      if (enter < length) sum += /** @type {number} */ (from[start + enter * step]);
      const leave = n - radius - 1;
      if (leave >= 0) sum -= /** @type {number} */ (from[start + leave * step]);
      if (n >= 0) to[start + n * step] = sum / (2 * radius + 1);
    }
  }
}

/** @param {Float32Array} field @param {number} wide @param {number} tall @param {number} radius in cells @returns {Float32Array} */
export function blurField(field, wide, tall, radius) {
  let a = Float32Array.from(field);
  const b = new Float32Array(field.length);
  for (let pass = 0; pass < 2; pass += 1) {
    blurLines(a, b, tall, wide, wide, 1, radius);
    blurLines(b, a, wide, tall, 1, wide, radius);
  }
  return a;
}

const SHADE_PER_M = 12;

/**
 * Soft shade of the racks and walls on the floor (R) and the racks' cover (G), both 0..255.
 * @param {HallPlan} hall @returns {{ data: Uint8Array, wide: number, tall: number }} rows from y = 0 up
 */
export function computeShade(hall) {
  const wide = Math.ceil(hall.hall_width_m * SHADE_PER_M);
  const tall = Math.ceil(hall.hall_height_m * SHADE_PER_M);
  const cover = new Float32Array(wide * tall);
  for (const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] of hall.shelves_m)
    for (let j = Math.round(y0 * SHADE_PER_M); j < Math.round(y1 * SHADE_PER_M); j += 1)
      cover.fill(1, j * wide + Math.round(x0 * SHADE_PER_M), j * wide + Math.round(x1 * SHADE_PER_M));
  const near = blurField(cover, wide, tall, 1);
  const far = blurField(cover, wide, tall, 7);
  const data = new Uint8Array(wide * tall * 4);
  for (let j = 0; j < tall; j += 1)
    for (let i = 0; i < wide; i += 1) {
      const n = j * wide + i;
      const wall = Math.min(i, j, wide - 1 - i, tall - 1 - j) / SHADE_PER_M;
      const light = (1 - 0.45 * (near[n] ?? 0)) * (1 - 0.7 * Math.min(1, 1.3 * (far[n] ?? 0))) * (1 - 0.3 * Math.exp(-wall / 0.5));
      data[4 * n] = 255 * light;
      data[4 * n + 1] = 255 * (near[n] ?? 0);
      data[4 * n + 3] = 255;
    }
  return { data, wide, tall };
}

/** A seamless tile of noise: mottling (R) and grain (G). @param {number} size power of two @returns {Uint8Array} RGBA */
export function makeConcrete(size) {
  const random = seededRandom(7);
  const grain = Float32Array.from({ length: size * size }, random);
  const value = new Float32Array(size * size);
  for (let octave = 0; octave < 5; octave += 1) {
    const cells = 4 << octave;
    const lattice = Float32Array.from({ length: cells * cells }, random);
    addOctave(value, size, lattice, cells, 0.5 ** (octave * 0.8 + 1));
  }
  const data = new Uint8Array(size * size * 4);
  for (let n = 0; n < size * size; n += 1) {
    data[4 * n] = 255 * Math.min(1, Math.max(0, (value[n] ?? 0) / 1.1));
    data[4 * n + 1] = 255 * (grain[n] ?? 0);
    data[4 * n + 3] = 255;
  }
  return data;
}

/** @param {Float32Array} value @param {number} size @param {Float32Array} lattice @param {number} cells @param {number} weight */
function addOctave(value, size, lattice, cells, weight) {
  const at = (/** @type {number} */ i, /** @type {number} */ j) => lattice[(j % cells) * cells + (i % cells)] ?? 0;
  for (let j = 0; j < size; j += 1)
    for (let i = 0; i < size; i += 1) {
      const x = (i / size) * cells;
      const y = (j / size) * cells;
      const i0 = Math.floor(x);
      const j0 = Math.floor(y);
      const s = (x - i0) ** 2 * (3 - 2 * (x - i0));
      const t = (y - j0) ** 2 * (3 - 2 * (y - j0));
      const low = at(i0, j0) * (1 - s) + at(i0 + 1, j0) * s;
      const high = at(i0, j0 + 1) * (1 - s) + at(i0 + 1, j0 + 1) * s;
      value[j * size + i] = (value[j * size + i] ?? 0) + weight * (low * (1 - t) + high * t);
    }
}
