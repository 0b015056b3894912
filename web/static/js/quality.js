// Measures how well the page keeps up while the world runs: frames in each second, frames that took
// long, and round trips to the server; a short report every few seconds.

const REPORT_EVERY_MS = 5000;
const LONG_FRAME_MS = 50;
const SECOND_MS = 1000;
const FIGURES_MAX = 8;

/** Gathers figures until they are taken as a report. */
export class QualityWatch {
  constructor() {
    /** @type {number[]} */
    this.fps = [];
    /** @type {number[]} */
    this.rtt_ms = [];
    this.longFrames = 0;
    this.longestFrame_ms = 0;
    this.lastFrame_ms = NaN;
    this.second_ms = NaN;
    this.frames = 0;
    this.reported_ms = NaN;
  }

  /** A frame was drawn while the world ran and the page was seen. @param {number} now_ms */
  frame(now_ms) {
    const passed_ms = now_ms - this.lastFrame_ms;
    this.lastFrame_ms = now_ms;
    if (Number.isNaN(passed_ms)) {
      this.second_ms = now_ms;
      this.frames = 0;
      return;
    }
    this.frames += 1;
    if (passed_ms > LONG_FRAME_MS) this.longFrames += 1;
    this.longestFrame_ms = Math.max(this.longestFrame_ms, passed_ms);
    const second_ms = now_ms - this.second_ms;
    if (second_ms < SECOND_MS) return;
    keep(this.fps, Math.round((this.frames * SECOND_MS) / second_ms));
    this.second_ms = now_ms;
    this.frames = 0;
  }

  /** The page was hidden or the world stood still: the second under way does not count. */
  interrupt() {
    this.lastFrame_ms = NaN;
  }

  /** @param {number} time_ms from ping to pong */
  roundTrip(time_ms) {
    if (Number.isFinite(time_ms)) keep(this.rtt_ms, Math.round(time_ms * 10) / 10);
  }

  /**
   * The report that is due, or null.
   * @param {number} now_ms @returns {import("./net/messages.js").QualityReport | null}
   */
  takeReport(now_ms) {
    if (Number.isNaN(this.reported_ms)) this.reported_ms = now_ms;
    if (now_ms - this.reported_ms < REPORT_EVERY_MS) return null;
    this.reported_ms = now_ms;
    const report = {
      fps: this.fps,
      rtt_ms: this.rtt_ms,
      long_frames: this.longFrames,
      longest_frame_ms: Math.round(this.longestFrame_ms),
    };
    this.fps = [];
    this.rtt_ms = [];
    this.longFrames = 0;
    this.longestFrame_ms = 0;
    return report;
  }
}

/** Keeps the newest few. @param {number[]} figures @param {number} figure */
function keep(figures, figure) {
  figures.push(Math.min(figure, 99999));
  if (figures.length > FIGURES_MAX) figures.shift();
}
