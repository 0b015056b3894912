// Who is here, who has the lead, and how far the others agree with the lead.

import { build } from "./dom.js";

/** @typedef {{ name: string, client: string }} PresentExpert */
/** @typedef {{ name: string, elements: Record<string, { kappa: number | null, pairs: number }> }} Agreement */
/** @typedef {{ takeLead: () => void, handOver: (client: string) => void }} PeopleHandlers */
/** @typedef {{ name: string, title: string }} Element */

/** Experts and their agreement. */
export class People {
  /** @param {HTMLElement} parent @param {readonly Element[]} elements @param {PeopleHandlers} handlers */
  constructor(parent, elements, handlers) {
    const document = parent.ownerDocument;
    this.document = document;
    this.elements = elements;
    this.handlers = handlers;
    this.list = build(document, "ul", { class: "experts" });
    this.agreement = build(document, "div", { class: "agreement" });
    this.isOver = false;
    parent.append(build(document, "h2", {}, "Experts"), this.list, this.agreement);
    this.showAgreement([]);
  }

  /** Shows the agreement alone: nobody is here any more. */
  showNobody() {
    this.list.hidden = true;
    this.isOver = true;
    this.showAgreement([]);
  }

  /** @param {PresentExpert[]} present @param {string | null} lead @param {string} me client of this page */
  show(present, lead, me) {
    const { document } = this;
    const items = present.map(({ name, client }) => {
      const mine = client === me;
      const item = build(document, "li", {}, build(document, "span", { class: "name" }, name + (mine ? " (you)" : "")));
      if (client === lead) item.append(build(document, "span", { class: "badge" }, "lead"));
      else if (lead === me) item.append(this.#button("Hand over", `Hand the lead over to ${name}`, () => this.handlers.handOver(client)));
      return item;
    });
    if (lead === null) items.unshift(build(document, "li", { class: "leaderless" }, "Nobody has the lead: no pairs are taken. ", this.#button("Take the lead", "Take the lead", () => this.handlers.takeLead())));
    else if (lead !== me) items.push(build(document, "li", { class: "hint" }, "Your settings are kept apart and compared with the lead's; they do not show."));
    this.list.replaceChildren(...items);
  }

  /** @param {string} text @param {string} name in full @param {() => void} action */
  #button(text, name, action) {
    const button = build(this.document, "button", { type: "button", class: "small", "aria-label": name, title: name }, text);
    button.addEventListener("click", action);
    return button;
  }

  /** @param {Agreement[]} experts all but the lead */
  showAgreement(experts) {
    const { document } = this;
    if (!experts.length) {
      const text = this.isOver
        ? "No second expert was here at a snapshot, so there is no agreement to tell."
        : "Agreement (Cohen's κ) appears once a second expert has been here at a snapshot.";
      this.agreement.replaceChildren(build(document, "p", { class: "aside" }, text));
      return;
    }
    const head = build(document, "tr", {}, build(document, "th", { scope: "col" }, "κ with the lead"), ...this.elements.map(({ title }) => build(document, "th", { scope: "col" }, title)));
    const rows = experts.map(({ name, elements }) =>
      build(document, "tr", {}, build(document, "th", { scope: "row" }, name), ...this.elements.map((element) => this.#cell(elements[element.name]))));
    this.agreement.replaceChildren(build(document, "table", {}, build(document, "thead", {}, head), build(document, "tbody", {}, ...rows)));
  }

  /** @param {{ kappa: number | null, pairs: number } | undefined} found */
  #cell(found) {
    const { document } = this;
    if (!found || found.kappa === null) return build(document, "td", { title: "Not defined: too few, or only one kind of answer" }, "–", build(document, "small", {}, ` n ${found?.pairs ?? 0}`));
    return build(document, "td", {}, found.kappa.toFixed(2), build(document, "small", {}, ` n ${found.pairs}`));
  }
}
