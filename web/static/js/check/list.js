// The visible list of checks: one line each, open until settled.

/** A list whose lines turn into "done" or "problem". */
export class CheckList {
  /** @param {HTMLElement} root a ul @param {Record<string, string>} lines text of each open line by name */
  constructor(root, lines) {
    /** @type {Map<string, HTMLElement>} */
    this.items = new Map();
    for (const [name, text] of Object.entries(lines)) {
      const item = root.ownerDocument.createElement("li");
      item.dataset.state = "open";
      item.dataset.check = name;
      item.textContent = text;
      this.items.set(name, item);
    }
    root.replaceChildren(...this.items.values());
  }

  /** @param {string} name @param {boolean} fine @param {string} text */
  settle(name, fine, text) {
    const item = this.items.get(name);
    if (!item) return;
    item.dataset.state = fine ? "done" : "problem";
    item.textContent = text;
  }
}
