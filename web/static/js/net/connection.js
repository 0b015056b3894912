// One live connection as a state machine: connecting -> open -> (lost -> connecting)* -> closed.
// A newer tab, a step that is no trial and a finished trial end it; anything else is tried again.

import { decodeBinary, decodeText, encodeHello, encodePing, WireError } from "./messages.js";

/** @typedef {import("./messages.js").TextMessage | import("./messages.js").BinaryMessage} Message */
/**
 * What is said on the line besides pings and binary messages.
 * @template {{ type: string }} Text
 * @typedef {object} Protocol
 * @property {() => string} hello the first message up @property {(text: string) => Text} decode
 * @property {string} greeting type of the message that says that the line is open
 */
/** @typedef {"connecting" | "open" | "lost" | "taken-over" | "reload" | "refused" | "finished"} ConnectionState */

const PING_EVERY_MS = 2000;
/** No word from the server for this long means that the line is dead. */
const SILENCE_MS = 8000;
const BACKOFF_FIRST_MS = 400;
const BACKOFF_LAST_MS = 6000;

/** What a close code asks for; every code not listed is tried again. */
const CLOSE_CODES = /** @type {Record<number, ConnectionState>} */ ({
  4400: "refused",
  4401: "refused",
  4403: "refused",
  4408: "reload",
  4409: "taken-over",
  4410: "reload",
  4411: "refused",
});

/**
 * Waiting time before a try: doubling, capped, with a random part so that a room full of
 * participants does not return in one wave.
 * @param {number} tries made since the last open connection @param {number} chance in [0, 1)
 */
export function backoff_ms(tries, chance) {
  const full = Math.min(BACKOFF_LAST_MS, BACKOFF_FIRST_MS * 2 ** Math.min(tries, 6));
  return full * (0.6 + 0.4 * chance);
}

/** @type {Protocol<import("./messages.js").TextMessage>} */
export const PARTICIPANT_PROTOCOL = { hello: encodeHello, decode: decodeText, greeting: "welcome" };

/**
 * Speaks to the server and reports messages and changes of state.
 * @template {{ type: string }} Text
 */
export class Connection {
  /**
   * @param {string} url ws:// or wss:// address
   * @param {{ message: (message: Text | import("./messages.js").BinaryMessage) => void, state: (state: ConnectionState, reason: string) => void }} handlers
   * @param {Protocol<Text>} protocol
   */
  constructor(url, handlers, protocol) {
    this.url = url;
    this.handlers = handlers;
    this.protocol = protocol;
    /** @type {ConnectionState} */
    this.state = "connecting";
    this.tries = 0;
    this.roundTrip_ms = NaN;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.heard_ms = 0;
    this.heartbeat = setInterval(() => this.#beat(), PING_EVERY_MS);
    this.#open();
  }

  /** @param {string | ArrayBuffer} frame @returns {boolean} whether it could be handed to the line */
  send(frame) {
    if (this.state !== "open" || this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(frame);
    return true;
  }

  /** Ends the connection for good: the trial is over. */
  finish() {
    this.#change("finished", "");
    clearInterval(this.heartbeat);
    this.socket?.close(1000);
  }

  get isFinal() {
    return this.state !== "connecting" && this.state !== "open" && this.state !== "lost";
  }

  #open() {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.heard_ms = performance.now();
      socket.send(this.protocol.hello());
    };
    socket.onmessage = (event) => {
      if (socket === this.socket) this.#hear(event.data);
    };
    socket.onclose = (event) => {
      if (socket === this.socket) this.#closed(event.code, event.reason);
    };
  }

  /** @param {string | ArrayBuffer} data */
  #hear(data) {
    this.heard_ms = performance.now();
    let message;
    try {
      message = typeof data === "string" ? this.protocol.decode(data) : decodeBinary(data);
    } catch (error) {
      if (!(error instanceof WireError)) throw error;
      console.error(error.message);
      return;
    }
    if (message.type === "pong" && "sent_ms" in message) this.roundTrip_ms = this.heard_ms - Number(message.sent_ms);
    if (message.type === this.protocol.greeting) {
      this.tries = 0;
      this.#change("open", "");
    }
    this.handlers.message(message);
  }

  /** @param {number} code @param {string} reason */
  #closed(code, reason) {
    if (this.isFinal) return;
    const next = CLOSE_CODES[code] ?? "lost";
    this.#change(next, reason);
    if (next !== "lost") {
      clearInterval(this.heartbeat);
      return;
    }
    const wait = backoff_ms(this.tries, Math.random());
    this.tries += 1;
    setTimeout(() => {
      if (this.state === "lost") {
        this.#change("connecting", reason);
        this.#open();
      }
    }, wait);
  }

  #beat() {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const now_ms = performance.now();
    if (now_ms - this.heard_ms > SILENCE_MS) this.#abandon();
    else this.socket.send(encodePing(now_ms));
  }

  /** Drops a line on which nothing arrives any more, without waiting for its closing handshake. */
  #abandon() {
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    this.#closed(1006, "the server went silent");
  }

  /** @param {ConnectionState} state @param {string} reason */
  #change(state, reason) {
    if (state === this.state) return;
    this.state = state;
    this.handlers.state(state, reason);
  }
}
