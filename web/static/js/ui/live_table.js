// The list of who is under way, told anew by the server every second.

import { build } from "./dom.js";
import { showOwnTimes } from "./own_times.js";

/**
 * @typedef {{ code: string, mode: string, status: string, step: string, condition: string, connection: string, phase: string, time: string, wait: string, boxes: string, seen: string, trial: string }} Row
 * @typedef {{ type: string, total: number, running: number, late_p99_ms: number, storage_failing_s: number | null, rows: Row[], message?: string }} People
 */

const RETRY_MS = 3000;
const PING_MS = 10_000;
const TEXTS = /** @type {const} */ (["mode", "status", "step", "condition", "connection", "phase", "time", "wait", "boxes"]);

/** Keeps the rows of one table as the server tells them. */
export class LiveTable {
  /** @param {HTMLTableElement} table */
  constructor(table) {
    this.document = table.ownerDocument;
    this.body = /** @type {HTMLTableSectionElement} */ (table.tBodies[0]);
    this.address = new URL(table.dataset.socket ?? "", location.href);
    this.address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    this.#open();
  }

  #open() {
    const socket = new WebSocket(this.address);
    const pings = setInterval(() => {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ type: "ping", sent_ms: performance.now() }));
    }, PING_MS);
    socket.onopen = () => socket.send(JSON.stringify({ type: "hello", version: 1 }));
    socket.onmessage = (event) => this.#hear(JSON.parse(String(event.data)));
    socket.onclose = (event) => {
      clearInterval(pings);
      const refused = event.code >= 4400;
      this.#say(refused ? event.reason || "The server refused this page; sign in again." : "Connection lost; the list is old. Trying again …", true);
      if (!refused) setTimeout(() => this.#open(), RETRY_MS);
    };
  }

  /** @param {People} message */
  #hear(message) {
    if (message.type !== "people") return;
    this.#say("Up to date, told every second.", false);
    this.#set("live-total", String(message.total));
    this.#set("live-running", String(message.running));
    this.#set("live-late", String(message.late_p99_ms));
    const storage = this.document.getElementById("live-storage");
    if (storage) storage.hidden = message.storage_failing_s === null;
    const empty = this.document.getElementById("live-empty");
    if (empty) empty.hidden = message.rows.length > 0;
    this.#show(message.rows);
  }

  /** Rows are changed in place, so that focus stays where it is. @param {Row[]} rows */
  #show(rows) {
    const known = new Map([...this.body.rows].map((row) => [row.dataset.code, row]));
    const wanted = rows.map((row) => this.#fill(known.get(row.code) ?? this.#make(row.code), row));
    const kept = new Set(wanted);
    for (const row of [...this.body.rows]) if (!kept.has(row)) row.remove();
    wanted.forEach((row, index) => {
      if (this.body.rows[index] !== row) this.body.insertBefore(row, this.body.rows[index] ?? null);
    });
  }

  /** @param {string} code */
  #make(code) {
    const row = this.document.createElement("tr");
    row.dataset.code = code;
    const link = build(this.document, "a", { class: "code", href: `/admin/participants/${code}` }, code);
    row.append(build(this.document, "th", { scope: "row" }, link));
    for (let cell = 0; cell < TEXTS.length + 2; cell += 1) row.append(this.document.createElement("td"));
    return row;
  }

  /** @param {HTMLTableRowElement} element @param {Row} row */
  #fill(element, row) {
    TEXTS.forEach((name, index) => {
      const cell = element.cells[index + 2];
      if (cell && cell.textContent !== row[name]) cell.textContent = row[name];
    });
    const seen = element.cells[TEXTS.length + 2];
    if (seen && seen.querySelector("time")?.dateTime !== row.seen) {
      seen.replaceChildren(build(this.document, "time", { datetime: row.seen, title: row.seen, "data-near": "" }, row.seen));
      showOwnTimes(seen);
    }
    const watch = element.cells[1];
    const address = row.trial ? `/admin/live/${row.trial}` : "";
    if (watch && (watch.querySelector("a")?.getAttribute("href") ?? "") !== address)
      watch.replaceChildren(...(address ? [build(this.document, "a", { href: address, "aria-label": `watch ${row.code}` }, "watch")] : []));
    return element;
  }

  /** @param {string} id @param {string} text */
  #set(id, text) {
    const element = this.document.getElementById(id);
    if (element && element.textContent !== text) element.textContent = text;
  }

  /** @param {string} text @param {boolean} isOld whether the list can no longer be trusted */
  #say(text, isOld) {
    this.#set("live-line", text);
    this.document.getElementById("live-line")?.classList.toggle("problem", isOld);
  }
}
