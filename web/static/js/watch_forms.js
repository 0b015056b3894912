// The forms under a watched trial: sent without leaving the picture, so that camera and moment stay.

/** @typedef {(text: string, isRefusal: boolean) => void} Say */

const AWAY = "Not stored: the server does not answer. Try again.";

/** What the server says of a form that it did not take. @param {Response} answer */
async function readProblem(answer) {
  try {
    const { error = "", next_step = "" } = await answer.json();
    return `Not stored: ${error}. ${next_step}`;
  } catch {
    return AWAY;
  }
}

/** Sends one form in the background; a redirect is how the server says that it was taken. */
export class QuietForm {
  /** @param {HTMLFormElement} form @param {(sent: URLSearchParams) => void} stored @param {Say} say */
  constructor(form, stored, say) {
    this.form = form;
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      const sent = new URLSearchParams([...new FormData(form)].map(([name, value]) => [name, String(value)]));
      const button = form.querySelector("button");
      if (button) button.disabled = true;
      try {
        const answer = await fetch(form.action, { method: "POST", body: sent, headers: { Accept: "application/json" }, redirect: "manual" });
        if (answer.type === "opaqueredirect") stored(sent);
        else say(await readProblem(answer), true);
      } catch {
        say(AWAY, true);
      }
      if (button) button.disabled = false;
    });
  }
}

/** A note: it is about the moment at which its first letter was typed. */
export class MomentForm {
  /** @param {HTMLFormElement} form @param {() => number} tick on the screen @param {(tick: number) => string} words for a tick @param {Say} say */
  constructor(form, tick, words, say) {
    const field = (/** @type {string} */ name) => /** @type {HTMLInputElement} */ (form.elements.namedItem(name));
    this.note = field("note");
    this.tickField = field("tick");
    this.label = /** @type {HTMLElement} */ (form.querySelector(".moment"));
    this.tick = tick;
    this.words = words;
    this.isHeld = false;
    this.note.addEventListener("input", () => {
      if (!this.isHeld) this.show();
      this.isHeld = this.note.value !== "";
    });
    new QuietForm(form, (sent) => {
      say(`Note kept at ${words(Number(sent.get("tick")))}`, false);
      this.note.value = "";
      this.isHeld = false;
    }, say);
  }

  /** The present moment, unless a note is being written. */
  show() {
    if (this.isHeld) return;
    const tick = this.tick();
    this.tickField.value = String(tick);
    const text = this.words(tick);
    if (this.label.textContent !== text) this.label.textContent = text;
  }
}
