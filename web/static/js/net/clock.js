// Follows the server's tick counter from the arrival of snapshots, so that robots can be drawn a
// steady moment in the past.

const OFFSETS_KEPT = 45;
/** How fast the drawn tick may be drawn towards the estimate, per second. */
const SLEW = 2;

/** Estimates the server's tick at any local moment; the quickest recent packets set the estimate. */
export class TickClock {
  /** @param {number} ticksPerSecond 30 x time scale @param {number} delay_ms how far in the past to draw */
  constructor(ticksPerSecond, delay_ms) {
    this.ticksPerMs = ticksPerSecond / 1000;
    this.delay_ms = delay_ms;
    /** @type {number[]} */
    this.offsets = [];
    this.smoothed = NaN;
    this.last_ms = NaN;
  }

  /** @param {number} tick @param {number} now_ms arrival time */
  hear(tick, now_ms) {
    this.offsets.push(tick - now_ms * this.ticksPerMs);
    if (this.offsets.length > OFFSETS_KEPT) this.offsets.shift();
  }

  /** Forgets everything: after a pause ticks and time no longer run together. */
  reset() {
    this.offsets.length = 0;
    this.smoothed = NaN;
  }

  /** @param {number} now_ms @returns {number} the tick to draw (fractional); NaN before the first snapshot */
  drawnTick(now_ms) {
    if (this.offsets.length === 0) return NaN;
    const estimate = Math.max(...this.offsets);
    const passed_s = Math.max(0, (now_ms - this.last_ms) / 1000);
    this.last_ms = now_ms;
    const gap = estimate - this.smoothed;
    if (Number.isNaN(gap) || Math.abs(gap) > 15) this.smoothed = estimate;
    else this.smoothed += gap * Math.min(1, SLEW * passed_s);
    return this.smoothed + (now_ms - this.delay_ms) * this.ticksPerMs;
  }
}
