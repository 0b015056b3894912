// Text messages of an expert's socket, both ways (version 1). Displays, plans, snapshots, welcomes and
// phases are those of a participant's socket (messages.js). The server's side is
// server/live/learning/wire.py.

import { decodeText, WireError } from "./messages.js";

export const EXPERT_VERSION = 1;

/**
 * Agents are numbered: robots from 0, then stations. Masks: robots 1 live location, 2 transparent
 * avatar, 4 trajectory; stations 1 balloon.
 * @typedef {[agent: number, on: number, off: number]} Change bits to set and bits to clear
 *
 * @typedef {object} LearningSettings as the server names them
 * @property {number} iterations @property {string} beta @property {string} box_mode
 * @property {string} label_source @property {string} pair_unit @property {string} classifier
 * @property {number} seed
 *
 * @typedef {object} Run
 * @property {"run"} type @property {string} run_id @property {number} version
 * @property {number} robots @property {number} stations @property {LearningSettings} settings
 * @property {"person" | "simulated"} worker @property {{ name: string, client: string }} you
 * @property {number} pairs_per_iteration @property {number} snapshot_ticks @property {number} taken_seq
 *
 * @typedef {object} Agents
 * @property {"agents"} type @property {number} trial @property {number} tick
 * @property {number[]} boxes @property {number[]} proposals @property {number[]} drawn masks by agent
 * @property {number[]} by_expert 1 where the expert's setting is displayed @property {boolean} recording
 * @property {number} taken_seq the newest message of this page that the boxes hold
 *
 * @typedef {object} Progress
 * @property {"progress"} type @property {number} trial @property {number} tick @property {number} pairs
 * @property {number} units @property {number} iteration @property {number} iterations
 * @property {number} beta @property {string} policy_sha256 @property {number} next_snapshot_tick
 *
 * @typedef {Record<string, number[]>} CurveLine values by measure
 * @typedef {{ type: "curve", from: number, lines: Record<string, CurveLine> }} Curve
 * @typedef {{ type: "stored", seq: number }} Stored
 * @typedef {{ type: "refused", seq: number, message: string }} Refused
 * @typedef {{ name: string, client: string }} PresentExpert
 * @typedef {{ type: "experts", lead: string | null, present: PresentExpert[] }} Experts
 * @typedef {{ kappa: number | null, pairs: number }} Kappa
 * @typedef {{ type: "agreement", experts: { name: string, elements: Record<string, Kappa> }[] }} Agreement
 * @typedef {{ type: "ended", status: "finished" | "stopped" }} Ended
 * @typedef {Run | Agents | Progress | Curve | Stored | Refused | Experts | Agreement | Ended} ExpertText
 */

/** A number for this page that no other page has. */
export function makeClient() {
  return Array.from(crypto.getRandomValues(new Uint8Array(8)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** @param {string} client @param {number} lastSeq the highest number this page has given */
export const encodeExpertHello = (client, lastSeq) =>
  JSON.stringify({ type: "hello", version: EXPERT_VERSION, client, last_seq: lastSeq });
/** @param {number} seq @param {{ trial: number, tick: number }} when @param {Change[]} changes */
export const encodeEdit = (seq, { trial, tick }, changes) => JSON.stringify({ type: "edit", seq, trial, tick, changes });
/** @param {number} seq @param {{ trial: number, tick: number }} when @param {number[]} agents */
export const encodeConfirm = (seq, { trial, tick }, agents) => JSON.stringify({ type: "confirm", seq, trial, tick, agents });
export const encodeTakeLead = () => JSON.stringify({ type: "take_lead" });
/** @param {string} to client */
export const encodeHandOver = (to) => JSON.stringify({ type: "hand_over", to });

/** What each message must carry: field and kind. */
const FIELDS = /** @type {Record<string, [string, string][]>} */ ({
  run: [["run_id", "string"], ["robots", "count"], ["stations", "count"], ["settings", "object"], ["worker", "string"],
    ["you", "object"], ["pairs_per_iteration", "count"], ["snapshot_ticks", "count"], ["taken_seq", "count"]],
  agents: [["trial", "count"], ["tick", "count"], ["boxes", "counts"], ["proposals", "counts"], ["drawn", "counts"],
    ["by_expert", "counts"], ["recording", "boolean"], ["taken_seq", "count"]],
  progress: [["trial", "count"], ["tick", "count"], ["pairs", "count"], ["iteration", "count"], ["iterations", "count"],
    ["beta", "number"], ["policy_sha256", "string"], ["next_snapshot_tick", "count"]],
  curve: [["from", "count"], ["lines", "object"]],
  stored: [["seq", "count"]],
  refused: [["seq", "count"], ["message", "string"]],
  experts: [["present", "array"]],
  agreement: [["experts", "array"]],
  ended: [["status", "string"]],
});

const isCount = (/** @type {unknown} */ value) => Number.isInteger(value) && /** @type {number} */ (value) >= 0;

const KINDS = /** @type {Record<string, (value: unknown) => boolean>} */ ({
  count: isCount,
  counts: (value) => Array.isArray(value) && value.every(isCount),
  array: Array.isArray,
  object: (value) => typeof value === "object" && value !== null && !Array.isArray(value),
  string: (value) => typeof value === "string",
  number: (value) => typeof value === "number",
  boolean: (value) => typeof value === "boolean",
});

/**
 * Reads a text message of the expert's socket.
 * @param {string} text @returns {ExpertText | import("./messages.js").TextMessage}
 * @throws {WireError} it does not fit
 */
export function decodeExpertText(text) {
  /** @type {any} */
  let message;
  try {
    message = JSON.parse(text);
  } catch {
    throw new WireError("a text message is not JSON");
  }
  const fields = message && typeof message === "object" ? FIELDS[message.type] : undefined;
  if (!fields) return decodeText(text);
  for (const [name, kind] of fields)
    if (!KINDS[kind]?.(message[name])) throw new WireError(`${message.type}: ${name} must be of kind ${kind}`, message[name]);
  if (message.type === "run" && message.version !== EXPERT_VERSION)
    throw new WireError(`run: this page speaks version ${EXPERT_VERSION}`, message.version);
  return message;
}
