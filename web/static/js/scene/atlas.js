// One picture that holds every sign, number plate, label and arrow of the hall, drawn on a canvas.

import { CanvasTexture, LinearFilter, LinearMipmapLinearFilter, SRGBColorSpace } from "three";
import { inkOn, robotColour, ROBOT_COLOURS, STATION_COLOURS } from "./palette.js";

const COLUMNS = 16;
const ROWS = 8;
const CELL_PX = 128;
/** Kept clear inside each cell, so that neighbours do not bleed in when the picture is scaled down. */
const EDGE_PX = 4;
const FONT = "system-ui, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";

/** @typedef {{ u0: number, v0: number, u1: number, v1: number }} CellRect */
/** @typedef {CanvasRenderingContext2D} Pen */

/** @param {number} column @param {number} row @param {number} [wide] @param {number} [tall] cells @returns {CellRect} v upwards */
function cell(column, row, wide = 1, tall = 1) {
  const edge = EDGE_PX / CELL_PX;
  return {
    u0: (column + edge) / COLUMNS,
    u1: (column + wide - edge) / COLUMNS,
    v0: 1 - (row + tall - edge) / ROWS,
    v1: 1 - (row + edge) / ROWS,
  };
}

/** @param {number} robot */
export const plateCell = (robot) => cell(robot % COLUMNS, 0);
/** @param {number} robot */
export const pillCell = (robot) => cell(robot % COLUMNS, 1);
/** @param {number} robot */
export const arrowCell = (robot) => cell(robot % COLUMNS, 2);
/** @param {number} station */
export const signCell = (station) => cell(2 * station, 3, 2, 2);
/** @param {number} station */
export const balloonLabelCell = (station) => cell(8 + 2 * station, 3, 2, 1);
/** @param {number} column of racks */
export const aisleCell = (column) => cell(column % COLUMNS, 5);
/** Charging mark of the robots' homes, and the hazard stripes of kerbs. */
export const CHARGE_CELL = cell(8, 4);
export const HAZARD_CELL = cell(9, 4, 4, 1);
/** A plain white spot: what has no picture points here. */
export const WHITE_CELL = Object.freeze({ u: (COLUMNS - 0.5) / COLUMNS, v: 0.5 / ROWS });

/** @param {Pen} pen @param {number} column @param {number} row @param {(pen: Pen) => void} draw with the cell's corner as origin */
function inCell(pen, column, row, draw) {
  pen.save();
  pen.translate(column * CELL_PX, row * CELL_PX);
  draw(pen);
  pen.restore();
}

/** @param {Pen} pen @param {string} text @param {number} x @param {number} y @param {number} px @param {string} colour */
function write(pen, text, x, y, px, colour) {
  pen.font = `800 ${px}px ${FONT}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillStyle = colour;
  pen.fillText(text, x, y + px * 0.05);
}

/** @param {Pen} pen @param {number} x @param {number} y @param {number} w @param {number} h @param {number} r */
function rounded(pen, x, y, w, h, r) {
  pen.beginPath();
  pen.roundRect(x, y, w, h, r);
}

/** @param {Pen} pen @param {number} robot */
function drawPlate(pen, robot) {
  const colour = robotColour(robot);
  pen.fillStyle = colour;
  pen.fillRect(0, 0, 128, 128);
  pen.strokeStyle = inkOn(colour);
  pen.globalAlpha = 0.85;
  pen.lineWidth = 5;
  pen.strokeRect(12, 12, 104, 104);
  pen.globalAlpha = 1;
  write(pen, String(robot + 1), 64, 64, robot < 9 ? 92 : 76, inkOn(colour));
}

/** @param {Pen} pen @param {number} robot */
function drawPill(pen, robot) {
  const colour = robotColour(robot);
  rounded(pen, 14, 14, 100, 100, 50);
  pen.fillStyle = "rgba(10, 14, 20, 0.55)";
  pen.fill();
  rounded(pen, 17, 17, 94, 94, 47);
  pen.fillStyle = "#ffffff";
  pen.fill();
  rounded(pen, 23, 23, 82, 82, 41);
  pen.fillStyle = colour;
  pen.fill();
  write(pen, String(robot + 1), 64, 64, robot < 9 ? 60 : 52, inkOn(colour));
}

/** An arrow head that points right. @param {Pen} pen @param {number} robot */
function drawArrow(pen, robot) {
  pen.beginPath();
  pen.moveTo(112, 64);
  pen.lineTo(30, 99);
  pen.lineTo(50, 64);
  pen.lineTo(30, 29);
  pen.closePath();
  pen.lineJoin = "round";
  pen.strokeStyle = "rgba(10, 14, 20, 0.55)";
  pen.lineWidth = 22;
  pen.stroke();
  pen.strokeStyle = "#ffffff";
  pen.lineWidth = 15;
  pen.stroke();
  pen.fillStyle = robotColour(robot);
  pen.fill();
}

/** @param {Pen} pen @param {number} station */
function drawSign(pen, station) {
  pen.fillStyle = STATION_COLOURS[station % 4] ?? "#888888";
  pen.fillRect(0, 0, 256, 256);
  pen.strokeStyle = "rgba(255, 255, 255, 0.9)";
  pen.lineWidth = 7;
  pen.strokeRect(17, 17, 222, 222);
  write(pen, "STATION", 128, 52, 36, "#ffffff");
  write(pen, String(station + 1), 128, 152, 168, "#ffffff");
}

/** @param {Pen} pen @param {number} station */
function drawBalloonLabel(pen, station) {
  rounded(pen, 8, 20, 240, 88, 44);
  pen.fillStyle = "rgba(10, 14, 20, 0.5)";
  pen.fill();
  rounded(pen, 11, 23, 234, 82, 41);
  pen.fillStyle = "#ffffff";
  pen.fill();
  write(pen, `Station ${station + 1}`, 128, 64, 40, "#b3121c");
}

/** @param {Pen} pen @param {number} column */
function drawAisle(pen, column) {
  pen.fillStyle = "#20303f";
  pen.fillRect(0, 0, 128, 128);
  pen.fillStyle = "#f4b400";
  pen.fillRect(0, 108, 128, 20);
  write(pen, String.fromCharCode(65 + column), 64, 56, 88, "#ffffff");
}

/** @param {Pen} pen */
function drawFixtures(pen) {
  inCell(pen, 8, 4, () => {
    pen.fillStyle = "#26323c";
    pen.fillRect(0, 0, 128, 128);
    pen.fillStyle = "#8fe388";
    pen.beginPath();
    for (const [x = 0, y = 0] of [[72, 18], [36, 72], [60, 72], [54, 110], [92, 54], [66, 54]]) pen.lineTo(x, y);
    pen.fill();
  });
  inCell(pen, 9, 4, () => {
    pen.beginPath();
    pen.rect(0, 0, 512, 128);
    pen.clip();
    pen.fillStyle = "#e8b21a";
    pen.fillRect(0, 0, 512, 128);
    pen.fillStyle = "#23262a";
    for (let x = -128; x < 640; x += 128) {
      pen.beginPath();
      for (const [dx = 0, y = 0] of [[0, 128], [64, 128], [192, 0], [128, 0]]) pen.lineTo(x + dx, y);
      pen.fill();
    }
  });
  pen.fillStyle = "#ffffff";
  pen.fillRect((COLUMNS - 1) * CELL_PX, (ROWS - 1) * CELL_PX, CELL_PX, CELL_PX);
}

/** @param {Document} document @returns {CanvasTexture} */
export function makeAtlas(document) {
  const canvas = document.createElement("canvas");
  canvas.width = COLUMNS * CELL_PX;
  canvas.height = ROWS * CELL_PX;
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  for (let robot = 0; robot < ROBOT_COLOURS.length; robot += 1) {
    inCell(pen, robot, 0, () => drawPlate(pen, robot));
    inCell(pen, robot, 1, () => drawPill(pen, robot));
    inCell(pen, robot, 2, () => drawArrow(pen, robot));
    inCell(pen, robot, 5, () => drawAisle(pen, robot));
  }
  for (let station = 0; station < 4; station += 1) {
    inCell(pen, 2 * station, 3, () => drawSign(pen, station));
    inCell(pen, 8 + 2 * station, 3, () => drawBalloonLabel(pen, station));
  }
  drawFixtures(pen);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.magFilter = LinearFilter;
  texture.anisotropy = 8;
  return texture;
}
