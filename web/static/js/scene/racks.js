// Open steel racks with three loaded decks, and all their boxes as one instanced mesh.

import {
  BoxGeometry, CanvasTexture, Color, InstancedMesh, Matrix4, MeshLambertMaterial, Quaternion, SRGBColorSpace, Vector3,
} from "three";
import { aisleCell } from "./atlas.js";
import { BOX_COLOURS } from "./palette.js";
import { RACK_DECKS_M, RACK_TOP_M, seededRandom } from "./space.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {import("./builder.js").MeshBuilder} MeshBuilder */

const POST = new Color("#3a5a80");
const BEAM = new Color("#c96a2e");
const DECK = new Color("#848b90");
const FOOT = new Color("#e2a91c");
const POST_M = 0.06;
const BOXES_PER_DECK = 4;

/** One end frame: two posts, feet, two ties and a diagonal. @param {MeshBuilder} builder @param {number} x @param {number} y0 @param {number} y1 */
function addFrame(builder, x, y0, y1) {
  for (const y of [y0, y1 - POST_M]) {
    builder.box([x, y, x + POST_M, y + POST_M], 0, RACK_TOP_M, POST);
    builder.box([x - 0.02, y - 0.02, x + POST_M + 0.02, y + POST_M + 0.02], 0, 0.05, FOOT);
  }
  const cx = x + POST_M / 2;
  for (const [low, high] of /** @type {[number, number][]} */ ([[0.2, 0.82], [1.48, 0.82], [1.54, 2.2]])) {
    const from = new Vector3(cx, low, -(y0 + POST_M));
    builder.bar(from, new Vector3(cx, high, -(y1 - POST_M)), 0.03, POST);
  }
}

/** @param {MeshBuilder} builder @param {number[]} shelf @param {number} column */
function addRack(builder, shelf, column) {
  const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] = shelf;
  addFrame(builder, x0, y0, y1);
  addFrame(builder, x1 - POST_M, y0, y1);
  for (const deck of RACK_DECKS_M) {
    builder.box([x0 + POST_M, y0 + 0.012, x1 - POST_M, y0 + 0.052], deck - 0.1, deck + 0.005, BEAM);
    builder.box([x0 + POST_M, y1 - 0.052, x1 - POST_M, y1 - 0.012], deck - 0.1, deck + 0.005, BEAM);
    builder.box([x0 + POST_M, y0 + 0.052, x1 - POST_M, y1 - 0.052], deck - 0.025, deck, DECK, { shade: 0.7 });
  }
  const picture = aisleCell(column);
  const [low, high] = [RACK_TOP_M - 0.26, RACK_TOP_M];
  const xl = x0 - 0.012;
  const xr = x1 + 0.012;
  const [a, b] = [y0 + 0.17, y1 - 0.17];
  builder.panel([[xl, low, -b], [xl, low, -a], [xl, high, -a], [xl, high, -b]], new Color("#ffffff"), picture);
  builder.panel([[xr, low, -a], [xr, low, -b], [xr, high, -b], [xr, high, -a]], new Color("#ffffff"), picture);
}

/** @param {MeshBuilder} builder @param {HallPlan} hall */
export function addRacks(builder, hall) {
  const columns = [...new Set(hall.shelves_m.map(([x0 = 0]) => x0))].sort((a, b) => a - b);
  for (const shelf of hall.shelves_m) addRack(builder, shelf, columns.indexOf(shelf[0] ?? 0));
}

/** Front of every box: shaded cardboard, tape and label; alpha says how much of the box's colour shows. @param {Document} document */
function drawBoxFace(document) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 256;
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const shade = pen.createLinearGradient(0, 0, 0, 256);
  shade.addColorStop(0, "#ffffff");
  shade.addColorStop(0.8, "#f0f0f0");
  shade.addColorStop(1, "#c4c4c4");
  pen.fillStyle = shade;
  pen.fillRect(0, 0, 256, 256);
  pen.strokeStyle = "rgba(0, 0, 0, 0.28)";
  pen.lineWidth = 10;
  pen.strokeRect(0, 0, 256, 256);
  pen.strokeStyle = "rgba(255, 255, 255, 0.35)";
  pen.lineWidth = 3;
  pen.strokeRect(8, 8, 240, 240);
  return { canvas, pen };
}

/** Tape and label are painted after the alpha mask is known. @param {Document} document */
export function makeBoxTexture(document) {
  const { canvas, pen } = drawBoxFace(document);
  const image = pen.getImageData(0, 0, 256, 256);
  const keep = (/** @type {number} */ x0, /** @type {number} */ y0, /** @type {number} */ x1, /** @type {number} */ y1, /** @type {number[]} */ rgb, /** @type {number} */ tint) => {
    for (let y = y0; y < y1; y += 1)
      for (let x = x0; x < x1; x += 1) image.data.set([...rgb, Math.round(tint * 255)], 4 * (y * 256 + x));
  };
  keep(108, 0, 148, 84, [222, 200, 160], 0.35);
  keep(150, 150, 232, 222, [250, 250, 248], 0.01);
  for (let n = 0; n < 14; n += 1) keep(158 + n * 5, 158, 158 + n * 5 + ((n * 7) % 3) + 1, 188, [30, 32, 36], 0.01);
  keep(158, 196, 216, 201, [90, 94, 100], 0.01);
  keep(158, 207, 198, 212, [90, 94, 100], 0.01);
  pen.putImageData(image, 0, 0);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  texture.premultiplyAlpha = false;
  texture.anisotropy = 4;
  return texture;
}

/** @param {import("three").Texture} face */
function makeBoxMaterial(face) {
  const material = new MeshLambertMaterial({ map: face });
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <map_fragment>", "vec4 face = texture2D(map, vMapUv);")
      .replace("#include <color_fragment>", "diffuseColor.rgb = face.rgb * mix(vec3(1.0), vColor.rgb, face.a);");
  };
  return material;
}

/** @typedef {{ matrix: Matrix4, colour: Color }} Placed */

/** @param {HallPlan} hall @returns {Placed[]} every box on every rack */
function stockRacks(hall) {
  const random = seededRandom(hall.box_seed);
  const colours = BOX_COLOURS.map((hex) => new Color(hex));
  /** @type {Placed[]} */
  const boxes = [];
  const up = new Vector3(0, 1, 0);
  for (const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] of hall.shelves_m)
    RACK_DECKS_M.forEach((deck) => {
      const first = Math.floor(random() * 4);
      const step = random() < 0.5 ? 1 : 3;
      const slot = (x1 - x0 - 2 * POST_M) / BOXES_PER_DECK;
      for (let n = 0; n < BOXES_PER_DECK; n += 1) {
        const size = new Vector3(slot * (0.84 + 0.12 * random()), 0.4 + 0.17 * random(), 0.44 + 0.08 * random());
        const x = x0 + POST_M + slot * (n + 0.5);
        const y = (y0 + y1) / 2 + (random() - 0.5) * 0.04;
        const turn = new Quaternion().setFromAxisAngle(up, (random() - 0.5) * 0.05 + (random() < 0.5 ? Math.PI : 0));
        const matrix = new Matrix4().compose(new Vector3(x, deck + size.y / 2 + 0.003, -y), turn, size);
        const colour = (colours[(first + n * step) % 4] ?? new Color()).clone().multiplyScalar(0.9 + 0.2 * random());
        boxes.push({ matrix, colour });
      }
    });
  return boxes;
}

/** All boxes on the racks. @param {HallPlan} hall @param {import("three").Texture} face */
export function makeBoxes(hall, face) {
  const stocked = stockRacks(hall);
  const mesh = new InstancedMesh(new BoxGeometry(1, 1, 1), makeBoxMaterial(face), stocked.length);
  mesh.frustumCulled = false;
  stocked.forEach(({ matrix, colour }, n) => {
    mesh.setMatrixAt(n, matrix);
    mesh.setColorAt(n, colour);
  });
  return mesh;
}
