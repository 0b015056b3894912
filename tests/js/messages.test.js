// The wire messages: what is encoded here can be read back, and what is broken is refused by name.

import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeBinary, decodeText, encodeInput, WireError } from "../../web/static/js/net/messages.js";

const WELCOME = {
  type: "welcome", version: 1, trial_id: "t1", label: "Display A", kind: "trial", tick_hz: 30, snapshot_hz: 15,
  time_scale: 1, tick: 0, cap_s: 1500, acknowledged_seq: 0, boxes_total: 36, boxes_delivered: 0,
  human: { x_m: 1, y_m: 2, yaw: 0 }, hall: {}, robots: 12, settings: { ribbon_widest_at: "goal" },
};

/** @param {number[]} bytes */
const buffer = (...bytes) => Uint8Array.from(bytes).buffer;

test("input frames are packed little endian in order", () => {
  const bytes = new Uint8Array(encodeInput(0x01020304, [{ keys: 5, yaw: 0xabcd }, { keys: 0, yaw: 65536 + 7 }]));
  assert.deepEqual([...bytes], [1, 4, 3, 2, 1, 2, 5, 0xcd, 0xab, 0, 7, 0]);
});

test("an input message holds one to eight frames and stays below 256 bytes", () => {
  const frame = { keys: 0, yaw: 0 };
  assert.throws(() => encodeInput(1, []), WireError);
  assert.throws(() => encodeInput(1, new Array(9).fill(frame)), /1 to 8 frames \(got 9\)/);
  assert.ok(encodeInput(1, new Array(8).fill(frame)).byteLength <= 256);
});

test("a snapshot is read field by field", () => {
  const bytes = new ArrayBuffer(20);
  const view = new DataView(bytes);
  view.setUint8(0, 2);
  view.setUint8(1, 1);
  view.setUint32(2, 70000, true);
  view.setUint16(6, 65535, true);
  view.setUint16(8, 512 * 3, true);
  view.setUint16(10, 256, true);
  view.setUint16(12, 16384, true);
  view.setUint16(14, 512 * 28 + 1, true);
  view.setUint16(16, 512, true);
  view.setUint8(18, 64);
  view.setUint8(19, 3 | (4 << 3));
  const snapshot = decodeBinary(bytes);
  assert.equal(snapshot.type, "snapshot");
  assert.ok(snapshot.type === "snapshot");
  assert.deepEqual(
    [snapshot.blocked, snapshot.tick, snapshot.acknowledged, snapshot.human],
    [true, 70000, 65535, { x_m: 3, y_m: 0.5, yaw: 16384 }],
  );
  assert.deepEqual(snapshot.robots, [{ x_m: 28 + 1 / 512, y_m: 1, heading: Math.PI / 2, state: 3, carrying: 3 }]);
});

test("a plan keeps cells of bays and homes outside the grid", () => {
  const plan = decodeBinary(buffer(3, 7, 2, 0, 0, 5, 47, 0));
  assert.deepEqual(plan, { type: "plan", robot: 7, corners: [[-1, 4], [46, -1]] });
  assert.deepEqual(decodeBinary(buffer(3, 0, 0, 0)), { type: "plan", robot: 0, corners: [] });
});

test("a display names every robot's mask and every balloon", () => {
  const display = decodeBinary(buffer(4, 3, 2, 7, 8, 4, 0, 1, 0, 1));
  assert.ok(display.type === "display");
  assert.deepEqual([display.overlays, [...display.robots], [...display.stations]], [3, [7, 8], [0, 1, 0, 1]]);
});

test("broken binary messages are refused", () => {
  const broken = [
    buffer(), buffer(9), buffer(2, 0, 0), buffer(...new Array(15).fill(2)), buffer(3), buffer(3, 0, 2, 0, 1, 1),
    buffer(3, 0, 0, 0, 1), buffer(4), buffer(4, 0, 9, 1), buffer(4, 0, 1, 1, 4, 0), buffer(4, 0, 1, 1, 1, 0, 0),
  ];
  for (const bytes of broken) assert.throws(() => decodeBinary(bytes), WireError, String([...new Uint8Array(bytes)]));
});

test("random bytes are read or refused, never anything else", () => {
  let state = 1;
  const next = () => (state = (state * 1103515245 + 12345) & 0x7fffffff) >> 8;
  for (let n = 0; n < 3000; n += 1) {
    const bytes = Uint8Array.from({ length: next() % 40 }, () => next() & 255);
    if (bytes.length && n % 2) bytes[0] = 2 + (n % 3);
    try {
      decodeBinary(bytes.buffer);
    } catch (error) {
      assert.ok(error instanceof WireError, String(error));
    }
  }
});

test("text messages are checked for their fields", () => {
  assert.deepEqual(decodeText(JSON.stringify(WELCOME)), WELCOME);
  assert.deepEqual(decodeText('{"type":"pong","sent_ms":1.5}'), { type: "pong", sent_ms: 1.5 });
  for (const text of ["", "3", "null", "[]", '{"type":"dance"}', '{"type":"pong"}', '{"type":"pong","sent_ms":"1"}', '{"type":"finished"}'])
    assert.throws(() => decodeText(text), WireError, text);
  assert.throws(() => decodeText(JSON.stringify({ ...WELCOME, version: 2 })), /speaks version 1 \(got 2\)/);
  assert.throws(() => decodeText(JSON.stringify({ ...WELCOME, hall: null })), /hall must be of type object/);
});
