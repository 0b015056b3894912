// Where key presses on the expert's page go: to the desk, the camera or the help, wherever the focus is.

/** @typedef {import("./expert_run.js").ExpertRun} ExpertRun */
/** @typedef {import("./input/hotkeys.js").Command} Command */

/** @param {EventTarget | null} target */
function isTextField(target) {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) return !["button", "checkbox", "radio", "submit"].includes(target.type);
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement || target.isContentEditable;
}

/** Whether a focused control outside the grid wants Space or Enter for itself. @param {EventTarget | null} target */
function isControl(target) {
  return target instanceof HTMLElement && target.closest("button, a, summary") !== null && target.closest("#agents") === null;
}

/** @param {ExpertRun} run @param {Command} command @returns {boolean} whether it meant something */
function obey(run, command) {
  if (command.type === "help") run.help.toggle();
  else if (command.type === "camera") run.spectator.chooseNext();
  else if (command.type === "numbers") run.spectator.toggleNumbers();
  else if (command.type === "refit") run.spectator.cameras?.refit();
  else {
    if (command.type === "row") run.spectator.flight.release("KeyS");
    return run.desk?.run(command) ?? false;
  }
  return true;
}

/** @param {ExpertRun} run @param {KeyboardEvent} event */
function press(run, event) {
  if (isTextField(event.target)) return;
  const isPlain = !event.ctrlKey && !event.metaKey && !event.altKey;
  const command = run.desk?.reader.read(event, performance.now()) ?? (event.key === "?" ? { type: /** @type {const} */ ("help") } : null);
  if (run.help.isOpen) {
    if (command?.type === "help") run.help.toggle();
    return;
  }
  const keepsFlight = isPlain && run.spectator.cameras?.mode !== "worker" && run.spectator.flight.press(event.code, performance.now());
  if (!command) {
    if (keepsFlight) event.preventDefault();
    return;
  }
  const isActivation = command.type === "row-toggle" || command.type === "cell-toggle";
  if (isActivation && isControl(event.target)) return;
  if (obey(run, command)) event.preventDefault();
}

/** @param {Document} document @param {ExpertRun} run */
export function listenToKeys(document, run) {
  const window = /** @type {Window} */ (document.defaultView);
  window.addEventListener("keydown", (event) => press(run, event));
  window.addEventListener("keyup", (event) => {
    run.spectator.flight.release(event.code);
    if (event.key === " " && event.target instanceof HTMLElement && event.target.closest("#agents")) event.preventDefault();
  });
  window.addEventListener("blur", () => run.spectator.flight.releaseAll());
  // A click leaves the keyboard with the page, so that Space goes on meaning the row.
  document.addEventListener("click", (event) => {
    const button = event.target instanceof HTMLElement ? event.target.closest("button") : null;
    if (event.detail > 0 && button && !button.closest("dialog, .menu")) button.blur();
  });
}

/** The link for the worker can be copied, and its strip put away. @param {Document} document */
export function offerCopies(document) {
  for (const button of document.querySelectorAll("button[data-copy], button[data-dismiss]")) {
    if (!(button instanceof HTMLButtonElement)) continue;
    const { copy, dismiss } = button.dataset;
    button.addEventListener("click", async () => {
      if (dismiss) document.getElementById(dismiss)?.remove();
      if (!copy) return;
      try {
        await navigator.clipboard.writeText(copy);
        button.textContent = "Copied";
      } catch {
        button.textContent = "Please select and copy it by hand";
      }
    });
  }
}
