// The page's own measurements: seconds are counted whole, pauses do not count, reports are taken once.

import assert from "node:assert/strict";
import { test } from "node:test";
import { QualityWatch } from "../../web/static/js/quality.js";

/** @param {QualityWatch} watch @param {number} from_ms @param {number} to_ms @param {number} step_ms */
function draw(watch, from_ms, to_ms, step_ms) {
  for (let now = from_ms; now <= to_ms; now += step_ms) watch.frame(now);
}

test("frames are counted by whole seconds and long ones apart", () => {
  const watch = new QualityWatch();
  assert.equal(watch.takeReport(0), null);
  draw(watch, 0, 2000, 20);
  watch.frame(2100);
  draw(watch, 2120, 3100, 20);
  const report = watch.takeReport(5000);
  assert.deepEqual(report, { fps: [50, 50, 46], rtt_ms: [], long_frames: 1, longest_frame_ms: 100 });
});

test("a hidden page or a pause is no slow frame", () => {
  const watch = new QualityWatch();
  watch.takeReport(0);
  draw(watch, 0, 500, 20);
  watch.interrupt();
  draw(watch, 9000, 10000, 20);
  const report = watch.takeReport(10001);
  assert.deepEqual([report?.fps, report?.long_frames, report?.longest_frame_ms], [[50], 0, 20]);
});

test("a report is due every five seconds and begins anew", () => {
  const watch = new QualityWatch();
  watch.takeReport(100);
  watch.roundTrip(NaN);
  watch.roundTrip(12.34);
  assert.equal(watch.takeReport(5099), null);
  assert.deepEqual(watch.takeReport(5100)?.rtt_ms, [12.3]);
  assert.equal(watch.takeReport(5101), null);
  assert.deepEqual(watch.takeReport(10200)?.rtt_ms, []);
});
