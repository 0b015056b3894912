// Robots between snapshots, and the clock that says which moment is drawn.

import assert from "node:assert/strict";
import { test } from "node:test";
import { TickClock } from "../../web/static/js/net/clock.js";
import { backoff_ms } from "../../web/static/js/net/connection.js";
import { SnapshotBuffer, turnBetween } from "../../web/static/js/net/snapshots.js";

/** @param {number} tick @param {Partial<import("../../web/static/js/net/messages.js").RobotSample>} robot */
const snapshot = (tick, robot) => /** @type {import("../../web/static/js/net/messages.js").Snapshot} */ ({
  type: "snapshot", tick, acknowledged: 0, blocked: false, human: { x_m: 0, y_m: 0, yaw: 0 },
  robots: [{ x_m: 0, y_m: 0, heading: 0, state: 0, carrying: -1, ...robot }],
});

/** @param {SnapshotBuffer} buffer @param {number} tick */
const only = (buffer, tick) => {
  const [robot] = buffer.sample(tick);
  assert.ok(robot);
  return robot;
};

test("positions are blended between the two snapshots around a tick", () => {
  const buffer = new SnapshotBuffer();
  for (const [tick, x_m] of [[10, 1], [12, 1.2], [14, 1.6]]) buffer.push(snapshot(tick ?? 0, { x_m: x_m ?? 0 }));
  assert.ok(Math.abs(only(buffer, 11).x_m - 1.1) < 1e-9);
  assert.ok(Math.abs(only(buffer, 13.5).x_m - 1.5) < 1e-9);
  assert.equal(only(buffer, 3).x_m, 1);
});

test("headings turn the short way round", () => {
  const buffer = new SnapshotBuffer();
  buffer.push(snapshot(0, { heading: 6.2 }));
  buffer.push(snapshot(2, { heading: 0.1 }));
  assert.ok(only(buffer, 1).heading > 6.2, "it goes on past a full turn, not back through zero");
  assert.ok(Math.abs(turnBetween(0.1, 6.2) + (0.1 + 2 * Math.PI - 6.2)) < 1e-9);
});

test("a robot goes on for at most three ticks beyond the newest snapshot", () => {
  const buffer = new SnapshotBuffer();
  buffer.push(snapshot(0, { x_m: 0 }));
  buffer.push(snapshot(2, { x_m: 0.2 }));
  assert.ok(Math.abs(only(buffer, 4).x_m - 0.4) < 1e-9);
  assert.ok(Math.abs(only(buffer, 400).x_m - 0.5) < 1e-9);
});

test("a late or doubled snapshot changes nothing; a jump is not blended", () => {
  const buffer = new SnapshotBuffer();
  buffer.push(snapshot(4, { x_m: 4 }));
  buffer.push(snapshot(2, { x_m: 9 }));
  buffer.push(snapshot(4, { x_m: 9 }));
  assert.equal(only(buffer, 4).x_m, 4);
  buffer.push(snapshot(6, { x_m: 20 }));
  assert.equal(only(buffer, 4.8).x_m, 4);
  assert.equal(only(buffer, 5.2).x_m, 20);
});

test("state and box change with the snapshot that brings them, not before", () => {
  const buffer = new SnapshotBuffer();
  buffer.push(snapshot(0, { state: 1, carrying: -1 }));
  buffer.push(snapshot(2, { state: 2, carrying: 3 }));
  assert.deepEqual([only(buffer, 1.9).state, only(buffer, 1.9).carrying], [1, -1]);
  assert.deepEqual([only(buffer, 2).state, only(buffer, 2).carrying], [2, 3]);
});

test("the drawn tick runs evenly although packets arrive unevenly", () => {
  const clock = new TickClock(30, 120);
  const jitter = [0, 25, 3, 14, 30, 6, 0, 19, 8, 2];
  let last = NaN;
  const steps = [];
  for (let n = 0; n < 300; n += 1) {
    const now_ms = n * 16;
    if (n % 4 === 0) clock.hear(Math.round((now_ms - (jitter[(n / 4) % 10] ?? 0)) * 0.03), now_ms);
    const drawn = clock.drawnTick(now_ms);
    if (n > 60) steps.push(drawn - last);
    last = drawn;
  }
  assert.ok(Math.min(...steps) > 0, "time never runs backwards");
  assert.ok(Math.max(...steps) < 2 * 16 * 0.03, "and never leaps");
});

test("waiting times between tries double up to a cap, and differ by chance", () => {
  assert.ok(backoff_ms(0, 0.5) < backoff_ms(2, 0.5));
  assert.equal(backoff_ms(50, 0.999) <= 6000, true);
  assert.notEqual(backoff_ms(3, 0.1), backoff_ms(3, 0.9));
});
