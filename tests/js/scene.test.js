// The geometry of what is drawn: ribbons, paths, arrows, labels, colours.

import assert from "node:assert/strict";
import { test } from "node:test";
import { edgeSpot, makeRoom, spreadBearings } from "../../web/static/js/scene/arrow_layout.js";
import { balloonHeight_m, balloonSize } from "../../web/static/js/scene/balloons.js";
import { layOutLabels } from "../../web/static/js/scene/label_layout.js";
import { inkOn, ROBOT_COLOURS, smallInkOn, STATION_COLOURS } from "../../web/static/js/scene/palette.js";
import { pathLength, pointAlong, progressAlong, roundPath } from "../../web/static/js/scene/paths.js";
import { buildBand, laneOffset, ribbonWidth } from "../../web/static/js/scene/ribbon_geometry.js";
import { Routes } from "../../web/static/js/scene/routes.js";

/** Corners of a staircase with the shortest legs there are, and long legs. */
const STAIRS = /** @type {[number, number][]} */ ([[0, 0], [0.6, 0], [0.6, 0.6], [1.2, 0.6], [1.2, 5], [-3, 5], [-3, 4.4], [-2.4, 4.4]]);

/** @param {import("../../web/static/js/scene/ribbon_geometry.js").Band} band @returns {number[]} areas of its triangles, anticlockwise positive */
function areas(band) {
  const x = (/** @type {number} */ n) => (band.centres[2 * n] ?? 0) + (band.sides[2 * n] ?? 0);
  const y = (/** @type {number} */ n) => (band.centres[2 * n + 1] ?? 0) + (band.sides[2 * n + 1] ?? 0);
  const result = [];
  for (let n = 0; n < band.indices.length; n += 3) {
    const [a = 0, b = 0, c = 0] = band.indices.slice(n, n + 3);
    result.push(((x(b) - x(a)) * (y(c) - y(a)) - (x(c) - x(a)) * (y(b) - y(a))) / 2);
  }
  return result;
}

test("a ribbon is widest at the goal, or at the robot if the study says so", () => {
  assert.ok(ribbonWidth(0, "goal") > ribbonWidth(5, "goal"));
  assert.ok(ribbonWidth(5, "goal") > ribbonWidth(20, "goal"));
  assert.equal(ribbonWidth(0, "robot"), ribbonWidth(100, "goal"));
  assert.equal(ribbonWidth(100, "robot"), ribbonWidth(0, "goal"));
});

test("a ribbon folds over itself at no corner, in any lane", () => {
  for (let robot = 0; robot < 16; robot += 1) {
    const band = buildBand(roundPath(STAIRS), (toGoal_m) => ribbonWidth(toGoal_m, "goal"), laneOffset(robot));
    assert.ok(Math.min(...areas(band)) > -1e-9, `robot ${robot}: ${Math.min(...areas(band))}`);
  }
});

test("every part of a ribbon knows how far along the path it lies, up to the goal", () => {
  const path = roundPath(STAIRS);
  const band = buildBand(path, () => 0.2, 0);
  assert.equal(band.along.length, band.across.length);
  assert.equal(Math.max(...band.along), pathLength(path));
  assert.ok(band.indices.every((n) => n < band.across.length));
});

test("rounded paths stay near their corners and know their length", () => {
  const path = roundPath([[0, 0], [3, 0], [3, 4]]);
  assert.ok(pathLength(path) > 6.7 && pathLength(path) < 7);
  assert.deepEqual(pointAlong(path, 0), { x: 0, y: 0, heading: 0 });
  const end = pointAlong(path, 99);
  assert.deepEqual([end.x, end.y], [3, 4]);
  assert.ok(path.every((point, n) => n === 0 || point.at > (path[n - 1]?.at ?? 0)));
});

test("a robot's progress follows its place and is not caught by a later stretch nearby", () => {
  const path = roundPath([[0, 0], [10, 0], [10, 0.6], [0, 0.6]]);
  assert.ok(Math.abs(progressAlong(path, 2, 0.05, 1.9) - 2) < 0.02);
  assert.ok(progressAlong(path, 2, 0.55, 1.9) < 3, "the way back is 8 m ahead: too far to be meant");
});

test("a ghost starts at the robot, ends at the goal and starts again", () => {
  const routes = new Routes(1);
  routes.set(0, [[0, 0], [10, 0]]);
  const first = routes.ghost(0, 0.01);
  assert.ok(first && first.x < 0.4);
  const seen = Array.from({ length: 200 }, (_, n) => routes.ghost(0, n * 0.05)?.x ?? 0);
  assert.ok(Math.max(...seen) > 6.2 && seen.slice(100).some((x) => x < 1));
  routes.set(0, []);
  assert.equal(routes.ghost(0, 1), null);
});

test("arrows sit on the inset edge of the view and point outwards", () => {
  const frame = { width: 1280, height: 720, inset: 50 };
  for (let bearing = -Math.PI; bearing <= Math.PI; bearing += 0.1) {
    const spot = edgeSpot(bearing, frame);
    const onEdge = Math.min(spot.x - 50, 1230 - spot.x, spot.y - 50, 670 - spot.y);
    assert.ok(Math.abs(onEdge) < 1e-6, `bearing ${bearing}`);
  }
  assert.ok(edgeSpot(Math.PI / 2, frame).x > 1200, "a robot on the right has its arrow on the right");
  assert.ok(edgeSpot(Math.PI, frame).y > 660, "a robot behind has its arrow below");
});

test("arrows of neighbours move apart and keep their order", () => {
  const spread = spreadBearings([1, 1.01, 0.99, -2], 0.2);
  const [a = 0, b = 0, c = 0, d = 0] = spread;
  assert.ok(c < a && a < b && d === -2);
  assert.ok(a - c > 0.19 && b - a > 0.19);
});

test("arrows make room for the minimap and for each other", () => {
  const frame = { width: 1280, height: 720, inset: 54 };
  const disc = { x: 124, y: 596, radius: 104 };
  const bearings = spreadBearings([-1.9, -2.0, -2.1, -2.3, -2.5, -2.7, -2.9, 3.0, 1.5], 0.16);
  const spots = bearings.map((bearing) => edgeSpot(bearing, frame));
  makeRoom(spots, frame, disc, 40);
  spots.forEach((a, n) => {
    assert.ok(Math.hypot(a.x - disc.x, a.y - disc.y) > disc.radius + 20, `${n} lies under the minimap`);
    spots.slice(n + 1).forEach((b) => assert.ok(Math.hypot(a.x - b.x, a.y - b.y) > 39, `${n} touches a neighbour`));
  });
});

test("a balloon stays in a level view, beside the station and far away", () => {
  for (let far_m = 1.2; far_m < 30; far_m += 0.2) {
    const top = balloonHeight_m(far_m, 1.65) + 0.62 * balloonSize(far_m);
    assert.ok((top - 1.65) / far_m < Math.tan(Math.PI / 6), `cut off at ${far_m} m`);
    assert.ok(balloonHeight_m(far_m, 1.65) - 0.62 * balloonSize(far_m) > 0.8, "above a loaded robot");
  }
});

test("labels do not pile up: the nearest stays, others move, the rest fade", () => {
  const label = (/** @type {number} */ depth_m) => ({ x: 100, y: 100, w: 30, h: 30, depth_m });
  const placements = layOutLabels([label(9), label(2), label(5), label(12), label(20)]);
  assert.deepEqual(placements[1], { dy: 0, alpha: 1 });
  assert.deepEqual([placements[2]?.dy, placements[0]?.dy, placements[3]?.dy], [-30, -60, -90]);
  assert.ok((placements[4]?.alpha ?? 1) < 0.5);
  assert.deepEqual(layOutLabels([label(1), { ...label(2), x: 200 }])[1], { dy: 0, alpha: 1 });
});

/** CIELAB of an sRGB hex colour. @param {string} hex @param {number[]} sight 3 x 3 matrix on linear RGB */
function lab(hex, sight) {
  const linear = [1, 3, 5].map((at) => {
    const v = parseInt(hex.slice(at, at + 2), 16) / 255;
    return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  });
  const [r = 0, g = 0, b = 0] = [0, 3, 6].map((row) =>
    Math.min(1, Math.max(0, linear.reduce((sum, v, n) => sum + v * (sight[row + n] ?? 0), 0))));
  const f = (/** @type {number} */ t) => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
  const x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047);
  const y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
  const z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

/** Machado, Oliveira and Fernandes 2009, full severity. */
const SIGHTS = {
  normal: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  protan: [0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998],
  deutan: [0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.01182, 0.04294, 0.968881],
  tritan: [1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.3039],
};

test("robot colours stay apart for colour-blind eyes, and their numbers are readable", () => {
  assert.ok(ROBOT_COLOURS.length >= 15);
  for (const [name, sight] of Object.entries(SIGHTS))
    ROBOT_COLOURS.forEach((a, n) => {
      for (const b of ROBOT_COLOURS.slice(n + 1)) {
        const [p, q] = [lab(a, sight), lab(b, sight)];
        const distance = Math.hypot(...p.map((v, k) => v - (q[k] ?? 0)));
        assert.ok(distance > 18, `${a} and ${b} under ${name} sight: ${distance.toFixed(1)}`);
      }
    });
  assert.equal(inkOn("#ffffff"), "#10151c");
  assert.equal(inkOn("#060060"), "#ffffff");
});

test("small type on every robot's and station's colour has a contrast of at least 4.5", () => {
  const light = (/** @type {string} */ hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  const luminance = (/** @type {string} */ hex) => light(hex).reduce((sum, v, n) => sum + v * ([0.2126, 0.7152, 0.0722][n] ?? 0), 0) + 0.05;
  for (const colour of [...ROBOT_COLOURS, ...STATION_COLOURS]) {
    const [a, b] = [luminance(colour), luminance(smallInkOn(colour))].sort((x, y) => y - x);
    assert.ok((a ?? 0) / (b ?? 1) >= 4.5, `${colour}: ${((a ?? 0) / (b ?? 1)).toFixed(2)}`);
  }
});
