// Keys on the page of a watched trial: cameras and flight, and a replay's moment.

/** @typedef {import("./watched_trial.js").WatchedTrial} WatchedTrial */

const JUMP_TICKS = 150;
const TEXT_FIELDS = "input:not([type=range]), textarea, select";

/** @param {WatchedTrial} page @param {KeyboardEvent} event @returns {boolean} whether it meant something */
function obey(page, event) {
  const { spectator } = page;
  const letter = event.key.toLowerCase();
  if (letter === "v") spectator.chooseNext();
  else if (letter === "n") spectator.toggleNumbers();
  else if (letter === "f") spectator.cameras?.refit();
  else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
    if (!page.addresses.isReplay) return false;
    page.seekTo(page.tick + (event.key === "ArrowLeft" ? -JUMP_TICKS : JUMP_TICKS));
  } else if (event.key === " ") page.togglePlay();
  else return spectator.cameras?.mode !== "worker" && spectator.flight.press(event.code, performance.now());
  return true;
}

/** @param {Document} document @param {WatchedTrial} page */
export function listenToWatchKeys(document, page) {
  const window = /** @type {Window} */ (document.defaultView);
  window.addEventListener("keydown", (event) => {
    const target = event.target instanceof HTMLElement ? event.target : document.body;
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches(TEXT_FIELDS)) return;
    if (event.key === " " && target.closest("button, a, summary")) return;
    if (obey(page, event)) event.preventDefault();
  });
  window.addEventListener("keyup", (event) => page.spectator.flight.release(event.code));
  window.addEventListener("blur", () => page.spectator.flight.releaseAll());
}
