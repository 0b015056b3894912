// The own human on this page: frames, kinematics, prediction and its correction by the server.

import assert from "node:assert/strict";
import { test } from "node:test";
import { FrameAccumulator } from "../../web/static/js/input/accumulator.js";
import { KEY_A, KEY_D, KEY_W, stepHuman, trigTable } from "../../web/static/js/input/kinematics.js";
import { HeldKeys } from "../../web/static/js/input/keys.js";
import { Look } from "../../web/static/js/input/look.js";
import { Prediction } from "../../web/static/js/input/prediction.js";

const HALL = { solids_m: [[4, -5, 5, 5]], human_speed_mps: 1.4 };
const FORWARD = { keys: KEY_W, yaw: 0 };

/** @param {number} fps @param {number} seconds */
function walk(fps, seconds) {
  const accumulator = new FrameAccumulator(30);
  accumulator.start(0);
  const human = new Prediction({ solids_m: [], human_speed_mps: 1.4 }, { x_m: 0, y_m: 0 }, 0);
  for (let n = 1; n <= fps * seconds; n += 1)
    for (let due = accumulator.advance((n * 1000) / fps); due > 0; due -= 1) human.apply(FORWARD, []);
  return human;
}

test("a key moves as far at 1 or 10 pictures per second as at 60 or 144", () => {
  const expected = walk(60, 6);
  assert.ok(Math.abs(expected.x_m - 1.4 * 6) < 0.05);
  for (const fps of [1, 10, 25, 144]) {
    assert.equal(walk(fps, 6).seq, expected.seq, `${fps} pictures per second`);
    assert.equal(walk(fps, 6).x_m, expected.x_m);
  }
});

test("after a long freeze the frames owed are limited", () => {
  const accumulator = new FrameAccumulator(30);
  accumulator.start(0);
  assert.equal(accumulator.advance(60_000), 45);
  accumulator.stop();
  assert.equal(accumulator.advance(90_000), 0);
});

test("directions follow the keys and the view; diagonals are no faster", () => {
  const table = trigTable();
  const step = (/** @type {number} */ keys, /** @type {number} */ yaw) => stepHuman({ x: 0, y: 0 }, keys, yaw, 1, table, [], []);
  assert.deepEqual(step(KEY_W, 0), { x: 1, y: 0, contact: false });
  assert.deepEqual(step(KEY_W, 16384), { x: 0, y: 1, contact: false });
  assert.deepEqual(step(KEY_D, 0), { x: 0, y: -1, contact: false });
  const both = step(KEY_W | KEY_A, 0);
  assert.ok(Math.abs(Math.hypot(both.x, both.y) - 1) < 1e-9);
});

test("a wall stops the way into it and lets the body slide along", () => {
  const human = new Prediction(HALL, { x_m: 3, y_m: 0 }, 0);
  for (let n = 0; n < 60; n += 1) human.apply({ keys: KEY_W, yaw: 4096 }, []);
  assert.ok(human.x_m <= 3.7 + 1e-9 && human.x_m > 3.69);
  assert.ok(human.y_m > 0.8, "it slid along the wall");
});

test("an agreeing server changes nothing, not even by its rounding", () => {
  const human = new Prediction(HALL, { x_m: 0, y_m: 0 }, 65530);
  for (let n = 0; n < 12; n += 1) human.apply(FORWARD, []);
  const { x_m } = human;
  const acknowledged = human.pending[7];
  assert.ok(acknowledged);
  human.reconcile(acknowledged.seq % 65536, { x_m: Math.round(acknowledged.x_m * 512) / 512, y_m: 0 }, []);
  assert.equal(human.x_m, x_m);
  assert.equal(human.pending.length, 4, "numbers above 65535 are matched as well");
  assert.deepEqual(human.offset, { x_m: 0, y_m: 0 });
});

test("a correction keeps the unacknowledged frames and fades in the picture", () => {
  const human = new Prediction(HALL, { x_m: 0, y_m: 0 }, 0);
  for (let n = 0; n < 6; n += 1) human.apply(FORWARD, []);
  const before = human.drawn({ keys: 0, yaw: 0 }, 0, []);
  human.reconcile(3, { x_m: 0.1, y_m: 0 }, []);
  assert.ok(Math.abs(human.x_m - (0.1 + (3 * 1.4) / 30)) < 1e-6);
  const after = human.drawn({ keys: 0, yaw: 0 }, 0, []);
  assert.ok(Math.abs(after.x_m - before.x_m) < 1e-9, "the picture does not jump");
  human.fade(1);
  assert.ok(Math.abs(human.drawn({ keys: 0, yaw: 0 }, 0, []).x_m - human.x_m) < 1e-4);
});

test("frames dropped by a pause give their numbers back", () => {
  const human = new Prediction(HALL, { x_m: 0, y_m: 0 }, 10);
  for (let n = 0; n < 5; n += 1) human.apply(FORWARD, []);
  human.reconcile(12, { x_m: (2 * 1.4) / 30, y_m: 0 }, []);
  human.dropPending({ x_m: (2 * 1.4) / 30, y_m: 0 });
  assert.equal(human.seq, 12);
});

test("keys are told by their place, and losing the keyboard lets go of all", () => {
  const held = new HeldKeys();
  assert.equal(held.press("KeyW"), true);
  held.press("ArrowUp");
  held.press("KeyE");
  assert.equal(held.press("KeyP"), false);
  held.release("ArrowUp");
  assert.deepEqual([held.bits, held.turn], [KEY_W, -1]);
  held.releaseAll();
  assert.deepEqual([held.bits, held.turn], [0, 0]);
});

test("the view ignores wild mouse jumps and keeps its pitch within limits", () => {
  const look = new Look(65535);
  assert.equal(look.yaw, 65535);
  look.moveMouse(900, 0);
  assert.equal(look.yaw, 65535);
  for (let n = 0; n < 100; n += 1) look.moveMouse(0, 190);
  assert.ok(look.pitch > -1.3 && look.pitch < -1.2);
  const before = look.heading;
  look.moveMouse(50, 0);
  assert.ok(look.heading < before, "moving right turns clockwise");
});
