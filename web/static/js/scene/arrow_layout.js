// Where the arrow for a robot outside the view sits: at the edge, like on a compass card whose top is
// straight ahead, and apart from its neighbours.

/** @typedef {{ x: number, y: number, angle: number }} EdgeSpot pixels, y down; angle of pointing, clockwise from right */
/** @typedef {{ width: number, height: number, inset: number }} Frame pixels */
/** @typedef {{ x: number, y: number, radius: number }} Disc pixels */

/**
 * The point of the inset rectangle in a direction from the middle of the view.
 * @param {number} bearing radians, 0 straight ahead (up), positive to the right
 * @param {Frame} frame @returns {EdgeSpot}
 */
export function edgeSpot(bearing, frame) {
  const dx = Math.sin(bearing);
  const dy = -Math.cos(bearing);
  const halfWidth = frame.width / 2 - frame.inset;
  const halfHeight = frame.height / 2 - frame.inset;
  const reach = Math.min(halfWidth / Math.max(1e-6, Math.abs(dx)), halfHeight / Math.max(1e-6, Math.abs(dy)));
  return { x: frame.width / 2 + dx * reach, y: frame.height / 2 + dy * reach, angle: Math.atan2(dy, dx) };
}

/** Whether a robot at this bearing and pitch stands inside the view. @param {number} bearing radians @param {number} halfView radians, horizontally */
export const isInView = (bearing, halfView) => Math.abs(bearing) < halfView;

/** Turns any angle into -pi..pi. @param {number} angle */
export const wrapAngle = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

/**
 * Moves bearings apart until neighbours differ by a least gap; the order is kept.
 * @param {number[]} bearings @param {number} gap radians @returns {number[]} in the order given
 */
export function spreadBearings(bearings, gap) {
  const order = bearings.map((_, n) => n).sort((a, b) => (bearings[a] ?? 0) - (bearings[b] ?? 0));
  const spread = order.map((n) => bearings[n] ?? 0);
  for (let pass = 0; pass < 12; pass += 1) {
    let moved = false;
    for (let n = 1; n < spread.length; n += 1) {
      const lack = gap - ((spread[n] ?? 0) - (spread[n - 1] ?? 0));
      if (lack <= 1e-4) continue;
      spread[n - 1] = (spread[n - 1] ?? 0) - lack / 2;
      spread[n] = (spread[n] ?? 0) + lack / 2;
      moved = true;
    }
    if (!moved) break;
  }
  /** @type {number[]} */
  const result = new Array(bearings.length).fill(0);
  order.forEach((n, rank) => (result[n] = spread[rank] ?? 0));
  return result;
}

/**
 * Moves spots at the left and the lower edge out of a disc in the lower left corner, and those beyond
 * it further along, so that none touches the disc or its neighbour.
 * @param {EdgeSpot[]} spots changed in place @param {Frame} frame @param {Disc} disc @param {number} size_px of a spot
 */
export function makeRoom(spots, frame, disc, size_px) {
  const clear = disc.radius + 0.8 * size_px;
  const isLeft = (/** @type {EdgeSpot} */ spot) => spot.x < frame.inset + 1;
  const left = spots.filter((spot) => isLeft(spot)).sort((a, b) => b.y - a.y);
  let limit = disc.y - clear;
  for (const spot of left) {
    spot.y = Math.max(frame.inset, Math.min(spot.y, limit));
    limit = spot.y - size_px;
  }
  const lower = spots.filter((spot) => !isLeft(spot) && spot.y > frame.height - frame.inset - 1).sort((a, b) => a.x - b.x);
  limit = disc.x + clear;
  for (const spot of lower) {
    spot.x = Math.min(frame.width - frame.inset, Math.max(spot.x, limit));
    limit = spot.x + size_px;
  }
}
