// Where the human looks: yaw goes to the server as a 16-bit turn, pitch stays on this page.

import { YAW_STEPS } from "./kinematics.js";

const RADIANS_PER_PIXEL = 0.0022;
/** Some mice report a wild jump now and then; nobody turns this far between two events. */
const SPIKE_PX = 200;
const PITCH_LIMIT = (70 * Math.PI) / 180;
const TURN_RADIANS_PER_S = (110 * Math.PI) / 180;

/** Heading and pitch of the view, in radians; heading anticlockwise from +x. */
export class Look {
  /** @param {number} yaw u16 */
  constructor(yaw = 0) {
    this.heading = 0;
    this.pitch = 0;
    this.setYaw(yaw);
  }

  /** @param {number} yaw u16 */
  setYaw(yaw) {
    this.heading = (yaw / YAW_STEPS) * 2 * Math.PI;
  }

  /** The heading as the server knows it. */
  get yaw() {
    const turns = this.heading / (2 * Math.PI);
    return Math.round((turns - Math.floor(turns)) * YAW_STEPS) & (YAW_STEPS - 1);
  }

  /** @param {number} dx_px @param {number} dy_px mouse motion, right and down positive */
  moveMouse(dx_px, dy_px) {
    if (Math.abs(dx_px) > SPIKE_PX || Math.abs(dy_px) > SPIKE_PX) return;
    this.heading -= dx_px * RADIANS_PER_PIXEL;
    const pitch = this.pitch - dy_px * RADIANS_PER_PIXEL;
    this.pitch = Math.max(-PITCH_LIMIT, Math.min(PITCH_LIMIT, pitch));
  }

  /** Turns by the keyboard. @param {number} direction 1 left, -1 right @param {number} seconds */
  turn(direction, seconds) {
    this.heading += direction * TURN_RADIANS_PER_S * seconds;
  }
}
