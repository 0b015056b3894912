// Facts about the running trial as data attributes of the stage, in every build: for tests, helpers
// and anybody who wants to know what the page thinks.

const EVERY_MS = 1000 / 15;

/**
 * @typedef {object} Facts
 * @property {string} phase @property {string} connection @property {number} tick
 * @property {number} x_m @property {number} y_m @property {number} yaw u16
 * @property {number} delivered boxes @property {number} frames drawn so far
 * @property {{ x_m: number, y_m: number, state: number }[]} robots
 */

/** Writes facts at most 15 times a second; phase and connection at once. */
export class Beacon {
  /** @param {HTMLElement} element */
  constructor(element) {
    this.element = element;
    this.last_ms = -Infinity;
  }

  /** @param {number} now_ms @param {() => Facts} ask */
  write(now_ms, ask) {
    if (now_ms - this.last_ms < EVERY_MS) return;
    this.last_ms = now_ms;
    const facts = ask();
    const { dataset } = this.element;
    dataset.phase = facts.phase;
    dataset.connection = facts.connection;
    dataset.tick = String(facts.tick);
    dataset.xM = facts.x_m.toFixed(3);
    dataset.yM = facts.y_m.toFixed(3);
    dataset.yaw = String(facts.yaw);
    dataset.boxesDelivered = String(facts.delivered);
    dataset.frames = String(facts.frames);
    dataset.robots = facts.robots.map((r, n) => `${n}:${r.x_m.toFixed(2)},${r.y_m.toFixed(2)},${r.state}`).join(";");
  }

  /** @param {string} phase @param {string} connection */
  announce(phase, connection) {
    this.element.dataset.phase = phase;
    this.element.dataset.connection = connection;
  }
}
