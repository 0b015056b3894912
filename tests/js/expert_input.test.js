// The expert's keys and cameras: what a key asks for, and where a spectator looks from.

import assert from "node:assert/strict";
import { test } from "node:test";
import { HeldFlight } from "../../web/static/js/input/flight.js";
import { HotkeyReader } from "../../web/static/js/input/hotkeys.js";
import { Cameras } from "../../web/static/js/scene/cameras.js";

/** @param {string} key @param {string} [code] @param {object} [more] */
const press = (key, code = "", more = {}) => ({ key, code: code || (/\d/.test(key) ? `Digit${key}` : ""), shiftKey: false, ctrlKey: false, metaKey: false, altKey: false, repeat: false, ...more });

/** @param {HotkeyReader} reader @param {string} keys one per character @param {number} [every_ms] */
function type(reader, keys, every_ms = 100) {
  return [...keys].map((key, n) => reader.read(press(key), 1000 + n * every_ms));
}

test("a number chooses a robot at once; a second digit in time makes it two-digit", () => {
  const reader = new HotkeyReader(15, 4);
  assert.deepEqual(type(reader, "12"), [{ type: "row", agent: 0 }, { type: "row", agent: 11 }]);
  assert.deepEqual(type(reader, "0"), [{ type: "row", agent: 9 }]);
  assert.deepEqual(type(new HotkeyReader(15, 4), "12", 2000), [{ type: "row", agent: 0 }, { type: "row", agent: 1 }]);
});

test("an element between two digits keeps them apart, so quick editing is never read wrongly", () => {
  const reader = new HotkeyReader(15, 4);
  assert.deepEqual(type(reader, "1t2l", 10), [
    { type: "row", agent: 0 }, { type: "element", key: "T" }, { type: "row", agent: 1 }, { type: "element", key: "L" },
  ]);
});

test("digits that make no robot together choose one each; missing robots are named", () => {
  const reader = new HotkeyReader(12, 4);
  assert.deepEqual(type(reader, "13"), [{ type: "row", agent: 0 }, { type: "row", agent: 2 }]);
  assert.deepEqual(type(new HotkeyReader(6, 4), "7"), [{ type: "unknown", sentence: "There is no robot 7." }]);
  assert.deepEqual(type(new HotkeyReader(6, 4), "0"), [{ type: "unknown", sentence: "There is no robot 10." }]);
});

test("S and a number choose a station for a moment only", () => {
  const reader = new HotkeyReader(12, 4);
  assert.deepEqual(type(reader, "s2b"), [{ type: "armed" }, { type: "row", agent: 13 }, { type: "element", key: "B" }]);
  assert.deepEqual(type(reader, "s7"), [{ type: "armed" }, { type: "unknown", sentence: "There is no station 7." }]);
  assert.deepEqual(type(reader, "s3", 1500)[1], { type: "row", agent: 2 });
});

test("Shift makes columns, and all rows right; Ctrl+Z takes back; other combinations are the browser's", () => {
  const reader = new HotkeyReader(12, 4);
  const shift = { shiftKey: true };
  assert.deepEqual(reader.read(press("G", "KeyG", shift), 0), { type: "column", key: "G" });
  assert.deepEqual(reader.read(press("R", "KeyR", shift), 0), { type: "all-right" });
  assert.deepEqual(reader.read(press("z", "KeyZ", { ctrlKey: true }), 0), { type: "undo" });
  for (const more of [{ ctrlKey: true }, { metaKey: true }, { altKey: true }]) assert.equal(reader.read(press("t", "KeyT", more), 0), null);
  assert.equal(reader.read(press("F5"), 0), null);
});

test("letters count by what they type, by their place where no such letter is typed", () => {
  const reader = new HotkeyReader(12, 4);
  assert.deepEqual(reader.read(press("t", "KeyK"), 0), { type: "element", key: "T" });
  assert.deepEqual(reader.read(press("е", "KeyT"), 0), { type: "element", key: "T" }, "a Cyrillic layout");
  assert.deepEqual(reader.read(press("&", "Digit1"), 0), { type: "row", agent: 0 }, "a French layout");
  assert.deepEqual(reader.read(press("?", "Minus"), 0), { type: "help" });
});

test("a held key toggles once, but moves the cursor on and on", () => {
  const reader = new HotkeyReader(12, 4);
  for (const key of ["t", " ", "r", "1"]) assert.equal(reader.read(press(key, "", { repeat: true }), 0), null, key);
  assert.deepEqual(reader.read(press("ArrowDown", "", { repeat: true }), 0), { type: "move", by: 1 });
});

test("keys that move the camera count by their place and cancel each other out", () => {
  const flight = new HeldFlight();
  for (const code of ["KeyW", "KeyS", "KeyD"]) assert.ok(flight.press(code, 0));
  assert.ok(!flight.press("KeyT", 0));
  assert.deepEqual(flight.motion(100), { forward: 1, right: 1, turn: 0, zoom: 0 }, "a tap on S is a station's, not the camera's");
  assert.deepEqual(flight.motion(400), { forward: 0, right: 1, turn: 0, zoom: 0 });
  flight.releaseAll();
  assert.ok(flight.isIdle);
});

const HALL = { hall_width_m: 28, hall_height_m: 21, eye_height_m: 1.65 };
const HUMAN = { x: 3, y: 4, heading: 1 };
const WIDE = { width: 1600, height: 900 };

/** Whether a place on the floor lies in a camera's picture. @param {import("../../web/static/js/scene/cameras.js").Sight} sight @param {number} x @param {number} y @param {{ width: number, height: number }} size */
function sees(sight, x, y, size) {
  const [dx, dy, dz] = [x - sight.x, y - sight.y, -sight.height_m];
  const [ch, sh, cp, sp] = [Math.cos(sight.heading), Math.sin(sight.heading), Math.cos(sight.pitch), Math.sin(sight.pitch)];
  const ahead = dx * ch * cp + dy * sh * cp + dz * sp;
  const right = dx * sh - dy * ch;
  const up = -dx * ch * sp - dy * sh * sp + dz * cp;
  const tan = Math.tan((sight.fov_deg * Math.PI) / 360);
  return ahead > sight.near_m && ahead < sight.far_m && Math.abs(up) <= ahead * tan && Math.abs(right) <= (ahead * tan * size.width) / size.height;
}

test("from above every hall is seen whole in every window, turned where that makes it larger", () => {
  for (const [w, h] of [[28, 21], [13, 21], [49, 52], [90, 12]])
    for (const size of [WIDE, { width: 700, height: 700 }, { width: 500, height: 900 }]) {
      const cameras = new Cameras({ ...HALL, hall_width_m: w, hall_height_m: h });
      const sight = cameras.sight(HUMAN, size);
      for (const [x, y] of [[0, 0], [w, 0], [w, h], [0, h]]) assert.ok(sees(sight, x, y, size), `${w} x ${h} in ${size.width} x ${size.height}`);
    }
  assert.ok(new Cameras({ ...HALL, hall_width_m: 13 }).isTurned(WIDE));
  assert.ok(!new Cameras(HALL).isTurned(WIDE));
});

test("the worker's camera stands where the worker stands and cannot be moved", () => {
  const cameras = new Cameras(HALL);
  cameras.choose("worker");
  cameras.pan(90, 90, WIDE);
  cameras.zoom(3, WIDE);
  const { x, y, heading, height_m, outside } = cameras.sight(HUMAN, WIDE);
  assert.deepEqual({ x, y, heading, height_m, outside }, { ...HUMAN, height_m: 1.65, outside: false });
});

test("the wheel keeps the place under the pointer, and far out the whole hall comes back", () => {
  const cameras = new Cameras(HALL);
  const at = { x: 1200, y: 200 };
  const under = () => {
    const scale = cameras.spanAbove(WIDE) / WIDE.height;
    return [cameras.above.x + (at.x - 800) * scale, cameras.above.y + (450 - at.y) * scale];
  };
  const before = under();
  cameras.zoom(4, WIDE, at);
  under().forEach((value, n) => assert.ok(Math.abs(value - (before[n] ?? NaN)) < 1e-9));
  cameras.zoom(-30, WIDE);
  assert.deepEqual(cameras.above, { x: 14, y: 10.5, zoom: 1 });
});

test("a drag moves the hall with the pointer, and no camera leaves the hall for good", () => {
  const cameras = new Cameras(HALL);
  cameras.zoom(6, WIDE);
  const { x } = cameras.above;
  cameras.pan(100, 0, WIDE);
  assert.ok(cameras.above.x < x);
  cameras.pan(1e6, -1e6, WIDE);
  assert.deepEqual([cameras.above.x, cameras.above.y], [0, 0]);
});

test("the free camera goes round what it looks at, above the floor, and flies by keys", () => {
  const cameras = new Cameras(HALL);
  cameras.choose("free");
  for (let n = 0; n < 60; n += 1) {
    cameras.turn(37, n % 2 ? 90 : -140, WIDE);
    const sight = cameras.sight(HUMAN, WIDE);
    assert.ok(sight.height_m > 0.3 && sees(sight, cameras.free.x, cameras.free.y, WIDE));
  }
  cameras.refit();
  const { y } = cameras.free;
  cameras.fly({ forward: 1, right: 0, turn: 0, zoom: 0 }, 0.5, WIDE);
  assert.ok(cameras.free.y > y);
});

test("cameras follow one another and keep their places", () => {
  const cameras = new Cameras(HALL);
  cameras.zoom(3, WIDE);
  const modes = [0, 1, 2].map(() => {
    cameras.chooseNext();
    return cameras.mode;
  });
  assert.deepEqual(modes, ["free", "worker", "above"]);
  assert.ok(cameras.above.zoom > 1.3);
});
