// The time to the next snapshot, and why there may be none.

/** World ticks per second. */
export const TICK_HZ = 30;

/**
 * @param {number} tick now, may be fractional @param {number} next tick of the next snapshot @param {number} span ticks between snapshots
 * @returns {{ seconds: number, share: number }} seconds of the world left, and the share of the span that is left
 */
export function countDown(tick, next, span) {
  const left = Math.max(0, Math.min(span, next - tick));
  return { seconds: left / TICK_HZ, share: span ? left / span : 0 };
}

/**
 * @typedef {object} Circumstances
 * @property {boolean} connected @property {string} phase of the trial @property {boolean} ended
 * @property {string | null | undefined} lead client; undefined while it is not known @property {boolean} recording
 * @property {"person" | "simulated"} worker
 */

/** Why no pairs are taken at the moment. @param {Circumstances} now @returns {string} empty while pairs are taken */
export function whyNotRecording(now) {
  if (now.ended) return "the run has ended";
  if (!now.connected) return "no connection";
  if (now.phase === "waiting") return now.worker === "person" ? "waiting for the worker" : "waiting for the simulated worker";
  if (now.phase === "paused") return "the worker is away";
  if (now.phase === "countdown" || now.lead === undefined) return "starting";
  if (now.phase === "finished") return "between two trials";
  if (now.lead === null) return "nobody has the lead";
  return now.recording ? "" : "the lead is away";
}
