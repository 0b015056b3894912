// The facts in the upper bar: trial and time, whether pairs are taken, the line to the server.

/** Round trips longer than this are called slow. */
const SLOW_MS = 250;

/** @param {number} seconds */
const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds) % 60).padStart(2, "0")}`;

/** @param {HTMLElement} element @param {string} text */
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Writes into the bar that the page brought along. */
export class RunBar {
  /** @param {{ facts: HTMLElement, recording: HTMLElement, line: HTMLElement }} places */
  constructor(places) {
    this.places = places;
  }

  /** @param {{ trial: number, seconds: number, boxes: number, boxesTotal: number }} now */
  showTrial({ trial, seconds, boxes, boxesTotal }) {
    write(this.places.facts, `, trial ${trial + 1}, ${clock(seconds)}, ${boxes} of ${boxesTotal} boxes`);
  }

  /** @param {string} reason why no pairs are taken; empty while they are */
  showRecording(reason) {
    const { recording } = this.places;
    recording.hidden = false;
    recording.dataset.kind = reason ? "waiting" : "on";
    write(recording, reason ? `Not recording: ${reason}` : "Recording");
  }

  /** The run has ended: there is no line any more. */
  hideLine() {
    this.places.line.hidden = true;
  }

  /** @param {boolean} open @param {number} roundTrip_ms NaN when not yet known @param {{ stored: number, pending: number }} changes */
  showLine(open, roundTrip_ms, { stored, pending }) {
    const { line } = this.places;
    line.hidden = false;
    line.dataset.quality = !open ? "lost" : roundTrip_ms > SLOW_MS ? "slow" : "good";
    const quality = !open ? "Not connected" : roundTrip_ms > SLOW_MS ? "Slow line" : "Connected";
    write(line, `${quality}, ${stored} stored${pending ? `, ${pending} waiting` : ""}`);
  }
}
