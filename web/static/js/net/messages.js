// Every message of the live socket, both ways (protocol version 1, little endian).
// The server's side is server/live/wire.py; a test holds the two equal.

export const PROTOCOL_VERSION = 1;
export const INPUT_FRAMES_MAX = 8;

const INPUT = 0x01;
const SNAPSHOT = 0x02;
const PLAN = 0x03;
const DISPLAY = 0x04;
const SNAPSHOT_HEAD = 14;
const SNAPSHOT_ROBOT = 6;

/** A message from the server that cannot be read: the text says what was wrong. */
export class WireError extends Error {
  /** @param {string} what @param {unknown} [detail] */
  constructor(what, detail) {
    super(detail === undefined ? what : `${what} (got ${String(detail)})`);
    this.name = "WireError";
  }
}

/**
 * @typedef {{ x_m: number, y_m: number, yaw: number }} Pose
 * @typedef {{ index: number, center_m: [number, number], bays: [number, number][] }} StationPlan
 * @typedef {object} HallPlan
 * @property {string} scale
 * @property {number} width_cells @property {number} height_cells
 * @property {number} hall_width_m @property {number} hall_height_m @property {number} cell_m
 * @property {number[][]} shelves_m @property {number} shelf_levels @property {number} box_seed
 * @property {StationPlan[]} stations @property {[number, number][]} homes @property {number[][]} solids_m
 * @property {number} human_speed_mps @property {number} human_radius_m
 * @property {number} robot_radius_m @property {number} eye_height_m
 *
 * @typedef {object} Welcome
 * @property {"welcome"} type @property {number} version @property {string} trial_id
 * @property {string} label @property {"trial" | "practice"} kind
 * @property {number} tick_hz @property {number} snapshot_hz @property {number} time_scale
 * @property {number} tick @property {number} cap_s @property {number} acknowledged_seq
 * @property {number} boxes_total @property {number} boxes_delivered @property {Pose} human
 * @property {HallPlan} hall @property {number} robots
 * @property {{ ribbon_widest_at: "goal" | "robot" }} settings
 *
 * @typedef {"waiting" | "countdown" | "running" | "paused" | "finished"} PhaseName
 * @typedef {{ type: "phase", phase: PhaseName, tick: number, seconds?: number, reason: string, acknowledged_seq?: number }} Phase
 * @typedef {{ type: "delivered", boxes: number }} Delivered
 * @typedef {{ type: "finished", next: string }} Finished
 * @typedef {{ type: "pong", sent_ms: number }} Pong
 * @typedef {{ type: "error", message: string }} Refusal
 * @typedef {Welcome | Phase | Delivered | Finished | Pong | Refusal} TextMessage
 *
 * @typedef {object} RobotSample
 * @property {number} x_m @property {number} y_m @property {number} heading radians, anticlockwise from +x
 * @property {number} state RobotState number @property {number} carrying colour 0..3, -1 for none
 *
 * @typedef {object} Snapshot
 * @property {"snapshot"} type @property {number} tick
 * @property {number} acknowledged u16 @property {boolean} blocked a robot stopped the human in this tick
 * @property {Pose} human @property {RobotSample[]} robots
 * @typedef {{ type: "plan", robot: number, corners: [number, number][] }} Plan
 * @typedef {{ type: "display", overlays: number, robots: Uint8Array, stations: Uint8Array }} Display
 * @typedef {Snapshot | Plan | Display} BinaryMessage
 */

/** The first frame of a connection. */
export const encodeHello = () => JSON.stringify({ type: "hello", version: PROTOCOL_VERSION });
/** Sent once the first frame of the hall has been drawn. */
export const encodeReady = () => JSON.stringify({ type: "ready" });
/** @param {number} sent_ms */
export const encodePing = (sent_ms) => JSON.stringify({ type: "ping", sent_ms });
/** @param {boolean} visible @param {boolean} focused @param {boolean} locked */
export const encodeAttention = (visible, focused, locked) =>
  JSON.stringify({ type: "attention", visible, focused, locked });
/**
 * What the page measured since its last report, at most eight figures of a kind.
 * @typedef {{ fps: number[], rtt_ms: number[], long_frames: number, longest_frame_ms: number }} QualityReport
 */
/** @param {QualityReport} report */
export const encodeQuality = (report) => JSON.stringify({ type: "quality", ...report });
/** @param {boolean} lost */
export const encodeContext = (lost) => JSON.stringify({ type: "context", lost });

/**
 * Packs up to eight consecutive input frames.
 * @param {number} firstSeq sequence number of the first frame, from 1
 * @param {ReadonlyArray<{ keys: number, yaw: number }>} frames
 * @returns {ArrayBuffer} u8 1, u32 first_seq, u8 n, n x (u8 keys, u16 yaw)
 */
export function encodeInput(firstSeq, frames) {
  if (frames.length < 1 || frames.length > INPUT_FRAMES_MAX)
    throw new WireError(`an input message holds 1 to ${INPUT_FRAMES_MAX} frames`, frames.length);
  const buffer = new ArrayBuffer(6 + 3 * frames.length);
  const view = new DataView(buffer);
  view.setUint8(0, INPUT);
  view.setUint32(1, firstSeq, true);
  view.setUint8(5, frames.length);
  frames.forEach((frame, n) => {
    view.setUint8(6 + 3 * n, frame.keys);
    view.setUint16(7 + 3 * n, frame.yaw & 65535, true);
  });
  return buffer;
}

/** What each text message must carry, by type: field and typeof. */
const TEXT_FIELDS = /** @type {Record<string, [string, string][]>} */ ({
  welcome: [["trial_id", "string"], ["hall", "object"], ["human", "object"], ["robots", "number"],
    ["tick", "number"], ["time_scale", "number"], ["acknowledged_seq", "number"],
    ["boxes_total", "number"], ["boxes_delivered", "number"], ["settings", "object"]],
  phase: [["phase", "string"], ["tick", "number"]],
  delivered: [["boxes", "number"]],
  finished: [["next", "string"]],
  pong: [["sent_ms", "number"]],
  error: [["message", "string"]],
});

/** @param {string} text @returns {TextMessage} */
export function decodeText(text) {
  /** @type {any} */
  let message;
  try {
    message = JSON.parse(text);
  } catch {
    throw new WireError("a text message is not JSON");
  }
  const fields = message && typeof message === "object" ? TEXT_FIELDS[message.type] : undefined;
  if (!fields) throw new WireError("a text message of unknown type", message?.type);
  for (const [name, type] of fields)
    if (typeof message[name] !== type || message[name] === null)
      throw new WireError(`${message.type}: ${name} must be of type ${type}`, message[name]);
  if (message.type === "welcome" && message.version !== PROTOCOL_VERSION)
    throw new WireError(`welcome: this page speaks version ${PROTOCOL_VERSION}`, message.version);
  return message;
}

/** @param {ArrayBuffer} buffer @returns {BinaryMessage} */
export function decodeBinary(buffer) {
  if (buffer.byteLength === 0) throw new WireError("an empty binary message");
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  if (kind === SNAPSHOT) return decodeSnapshot(view);
  if (kind === PLAN) return decodePlan(view);
  if (kind === DISPLAY) return decodeDisplay(view, buffer);
  throw new WireError("a binary message of unknown kind", kind);
}

/** @param {DataView} view @returns {Snapshot} */
function decodeSnapshot(view) {
  const rest = view.byteLength - SNAPSHOT_HEAD;
  if (rest < 0 || rest % SNAPSHOT_ROBOT !== 0)
    throw new WireError("a snapshot has 14 bytes and 6 per robot", view.byteLength);
  const robots = Array.from({ length: rest / SNAPSHOT_ROBOT }, (_, n) => {
    const at = SNAPSHOT_HEAD + SNAPSHOT_ROBOT * n;
    const bits = view.getUint8(at + 5);
    return {
      x_m: view.getUint16(at, true) / 512,
      y_m: view.getUint16(at + 2, true) / 512,
      heading: (view.getUint8(at + 4) / 256) * 2 * Math.PI,
      state: bits & 7,
      carrying: ((bits >> 3) & 7) - 1,
    };
  });
  return {
    type: "snapshot",
    blocked: (view.getUint8(1) & 1) === 1,
    tick: view.getUint32(2, true),
    acknowledged: view.getUint16(6, true),
    human: {
      x_m: view.getUint16(8, true) / 512,
      y_m: view.getUint16(10, true) / 512,
      yaw: view.getUint16(12, true),
    },
    robots,
  };
}

/** @param {DataView} view @returns {Plan} */
function decodePlan(view) {
  const corners = view.byteLength < 4 ? -1 : view.getUint16(2, true);
  if (view.byteLength !== 4 + 2 * corners)
    throw new WireError("a plan's length does not fit its number of corners", view.byteLength);
  return {
    type: "plan",
    robot: view.getUint8(1),
    corners: Array.from({ length: corners }, (_, n) => [
      view.getUint8(4 + 2 * n) - 1,
      view.getUint8(5 + 2 * n) - 1,
    ]),
  };
}

/** @param {DataView} view @param {ArrayBuffer} buffer @returns {Display} */
function decodeDisplay(view, buffer) {
  const robots = view.byteLength < 4 ? -1 : view.getUint8(2);
  const stations = view.byteLength < 4 + robots ? -1 : view.getUint8(3 + robots);
  if (robots < 0 || stations < 0 || view.byteLength !== 4 + robots + stations)
    throw new WireError("a display message's length does not fit its counts", view.byteLength);
  return {
    type: "display",
    overlays: view.getUint8(1),
    robots: new Uint8Array(buffer.slice(3, 3 + robots)),
    stations: new Uint8Array(buffer.slice(4 + robots)),
  };
}
