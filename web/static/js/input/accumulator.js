// Turns time into input frames: one per 1/30 s of world time, however often the screen is drawn.

/** Frames owed beyond this are forgotten: the human simply did not move meanwhile. */
const OWED_FRAMES_MAX = 45;

/** A fixed-step accumulator over a wall clock. */
export class FrameAccumulator {
  /** @param {number} framesPerSecond 30 x time scale */
  constructor(framesPerSecond) {
    this.framesPerSecond = framesPerSecond;
    this.owed = 0;
    this.last_ms = NaN;
  }

  /** Starts counting at a moment; nothing is owed before it. @param {number} now_ms */
  start(now_ms) {
    this.owed = 0;
    this.last_ms = now_ms;
  }

  stop() {
    this.owed = 0;
    this.last_ms = NaN;
  }

  get isRunning() {
    return !Number.isNaN(this.last_ms);
  }

  /** @param {number} now_ms @returns {number} whole frames to make now */
  advance(now_ms) {
    if (!this.isRunning) return 0;
    this.owed += (Math.max(0, now_ms - this.last_ms) * this.framesPerSecond) / 1000;
    this.last_ms = now_ms;
    const limit = OWED_FRAMES_MAX * Math.max(1, this.framesPerSecond / 30);
    if (this.owed > limit) this.owed = limit;
    const frames = Math.floor(this.owed + 1e-9);
    this.owed = Math.max(0, this.owed - frames);
    return frames;
  }

  /** How far the running frame has come, in [0, 1). */
  get fraction() {
    return Math.min(this.owed, 0.999);
  }
}
