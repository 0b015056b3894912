// The grid of all agents: a row per robot and per station. A cell shows the expert's setting as a
// box with or without a tick, what is displayed now as a full or a hollow lamp, and by hatching that
// the element marks nothing at the moment: a ribbon without a path, a balloon where nobody waits.

import { build } from "./dom.js";

/** @typedef {{ on: boolean, shown: boolean, drawn: boolean, pending: boolean, refused: boolean }} CellLook */
/** @typedef {{ status: string, chosen: boolean, owner: string, confirmed: "" | "pending" | "done", cells: CellLook[] }} RowLook */
/** @typedef {{ name: string, title: string, key: string, bit: number, of: "robot" | "station" }} Column */
/** @typedef {{ number: string, key: string, name: string, colour: string, ink: string, columns: readonly Column[] }} RowHead */
/**
 * @typedef {object} GridHandlers
 * @property {(agent: number, side: number) => void} choose a row and the cell in it
 * @property {(agent: number, bit: number) => void} cell toggled
 * @property {(key: string) => void} column toggled
 * @property {(agent: number) => void} right
 */

/** @param {CellLook} look */
function describe({ on, shown, drawn, pending, refused }) {
  const words = [on ? "set on" : "set off", shown ? "displayed" : "not displayed"];
  if (!drawn) words.push("marks nothing now");
  if (pending) words.push("not yet stored");
  if (refused) words.push("refused");
  return words.join(", ");
}

/** One row: its head, its cells, and what they showed last. */
class Row {
  /** @param {Document} document @param {number} agent @param {RowHead} head @param {GridHandlers} handlers */
  constructor(document, agent, head, handlers) {
    this.head = head;
    /** @type {string[]} */
    this.seen = [];
    const swatch = build(document, "button", { type: "button", class: "swatch", tabindex: "-1", "aria-label": `${head.name}, key ${head.key}` }, head.number);
    swatch.style.backgroundColor = head.colour;
    swatch.style.color = head.ink;
    swatch.addEventListener("click", () => handlers.choose(agent, 0));
    this.status = build(document, "span", { class: "status" });
    this.cells = head.columns.map((column, side) => {
      const cell = build(
        document, "button", { type: "button", class: "cell", role: "checkbox", tabindex: "-1", "data-agent": String(agent), "data-element": column.name },
        build(document, "span", { class: "box", "aria-hidden": "true" }), build(document, "span", { class: "lamp", "aria-hidden": "true" }),
      );
      cell.addEventListener("click", () => {
        handlers.choose(agent, side);
        handlers.cell(agent, column.bit);
      });
      return cell;
    });
    this.owner = build(document, "td", { class: "owner" });
    const right = build(document, "button", { type: "button", class: "right", tabindex: "-1", "aria-label": `${head.name} is right as it is (R)`, title: "This row is right (R)" }, "✓");
    right.addEventListener("click", () => {
      handlers.choose(agent, 0);
      handlers.right(agent);
    });
    const spare = head.columns.length < 3 ? [build(document, "td", { colspan: "2", class: "spare" })] : [];
    this.root = build(
      document, "tr", { "data-agent": String(agent) },
      build(document, "th", { scope: "row" }, swatch, this.status),
      ...this.cells.map((cell) => build(document, "td", {}, cell)), ...spare, this.owner, build(document, "td", {}, right),
    );
  }

  /** @param {RowLook} look */
  show(look) {
    if (this.status.textContent !== look.status) this.status.textContent = look.status;
    if (this.owner.textContent !== look.owner) this.owner.textContent = look.owner;
    this.root.classList.toggle("chosen", look.chosen);
    this.root.dataset.confirmed = look.confirmed;
    look.cells.forEach((cell, side) => this.#showCell(side, cell));
  }

  /** @param {number} side @param {CellLook} look */
  #showCell(side, look) {
    const text = describe(look);
    const cell = this.cells[side];
    if (!cell || this.seen[side] === text) return;
    this.seen[side] = text;
    const { title = "" } = this.head.columns[side] ?? {};
    cell.setAttribute("aria-checked", String(look.on));
    cell.setAttribute("aria-label", `${this.head.name}, ${title.toLowerCase()}: ${text}`);
    cell.title = `${title}: ${text}`;
    for (const name of /** @type {const} */ (["shown", "drawn", "pending", "refused"])) cell.toggleAttribute(`data-${name}`, look[name]);
  }
}

/** @param {Document} document @param {readonly Column[]} columns @param {string} title @param {GridHandlers} handlers */
function buildHead(document, columns, title, handlers) {
  const heads = columns.map((column) => {
    const button = build(
      document, "button", { type: "button", class: "column", tabindex: "-1", title: `Switch the whole column (Shift+${column.key})` },
      build(document, "kbd", {}, column.key), build(document, "span", {}, column.title),
    );
    button.addEventListener("click", () => handlers.column(column.key));
    return build(document, "th", { scope: "col" }, button);
  });
  const spare = columns.length < 3 ? [build(document, "td", { colspan: "2" })] : [];
  return build(
    document, "thead", {},
    build(document, "tr", {}, build(document, "th", { scope: "col", class: "what" }, title), ...heads, ...spare,
      build(document, "th", { scope: "col", class: "owner", title: "Whose choice is displayed" }, "by"), build(document, "th", { scope: "col" }, build(document, "span", { class: "visually-hidden" }, "Right"))),
  );
}

/** The grid; one cell of it can be reached with the Tab key. */
export class AgentGrid {
  /** @param {HTMLElement} parent @param {readonly RowHead[]} heads by agent @param {GridHandlers} handlers */
  constructor(parent, heads, handlers) {
    const document = parent.ownerDocument;
    this.document = document;
    this.rows = heads.map((head, agent) => new Row(document, agent, head, handlers));
    const tables = /** @type {const} */ (["robot", "station"]).map((kind) => {
      const of = (/** @type {RowHead} */ head) => head.columns[0]?.of === kind;
      const first = heads.find(of);
      if (!first) return [];
      const rows = this.rows.filter((row) => of(row.head)).map((row) => row.root);
      const caption = build(document, "caption", { class: "visually-hidden" }, kind === "robot" ? "Robots" : "Stations");
      return [build(document, "table", { class: `grid ${kind}s` }, caption,
        buildHead(document, first.columns, kind === "robot" ? "Robot" : "Station", handlers), build(document, "tbody", {}, ...rows))];
    });
    parent.replaceChildren(...tables.flat(), this.#buildLegend());
    /** @type {HTMLElement | null} the cell that Tab reaches */
    this.stop = null;
  }

  #buildLegend() {
    const { document } = this;
    const item = (/** @type {string} */ kind, /** @type {string} */ text) =>
      build(document, "li", {}, build(document, "span", { class: `mark ${kind}`, "aria-hidden": "true" }), text);
    return build(
      document, "ul", { class: "legend" },
      ...[["Space", "row"], ["R", "right"], ["U", "undo"]].map(([key = "", text = ""]) => build(document, "li", { class: "key" }, build(document, "kbd", {}, key), text)),
      item("ticked", "your setting"), item("lit", "displayed now"), item("dark", "not displayed"), item("hatched", "marks nothing now"), item("waiting", "not yet stored"),
    );
  }

  /** @param {RowLook[]} looks by agent */
  show(looks) {
    looks.forEach((look, agent) => this.rows[agent]?.show(look));
  }

  /** Puts the cursor on a cell; the keyboard's focus follows if it is in the grid. @param {number} agent @param {number} side */
  choose(agent, side) {
    const row = this.rows[agent];
    const cell = row?.cells[Math.min(side, row.cells.length - 1)];
    if (!row || !cell) return;
    const hadFocus = this.stop !== null && this.document.activeElement === this.stop;
    this.stop?.setAttribute("tabindex", "-1");
    this.stop = cell;
    cell.setAttribute("tabindex", "0");
    if (hadFocus) cell.focus({ preventScroll: true });
    row.root.scrollIntoView({ block: "nearest" });
  }
}
