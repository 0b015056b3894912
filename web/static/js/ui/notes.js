// The texts of everything that may lie over the view.

/** @typedef {{ title: string, lines: string[], busy?: boolean }} Note */

/** @type {Record<string, Note>} */
export const NOTES = Object.freeze({
  loading: { title: "Preparing the warehouse", lines: ["One moment, please."], busy: true },
  waiting: { title: "Ready when you are", lines: ["The round starts as soon as this page is in front."], busy: true },
  paused: { title: "The warehouse is paused", lines: ["Nothing moves and no time passes. It goes on in a moment."], busy: true },
  lost: {
    title: "Connection lost",
    lines: ["The world is paused and your progress is kept.", "This page is trying to reconnect; you need not do anything."],
    busy: true,
  },
  "taken-over": {
    title: "You went on in another tab",
    lines: ["This round is now open in a newer tab or window. You can close this one."],
  },
  refused: {
    title: "This page cannot go on",
    lines: ["Please load the page again. If that does not help, open your personal link once more."],
  },
  finished: { title: "Round finished", lines: ["Thank you. Your result is being saved, then the next page opens."], busy: true },
  "no-webgl": {
    title: "3D graphics are not available",
    lines: [
      "This browser cannot draw the warehouse, because WebGL 2 is missing or switched off.",
      "Please open your personal link in a current Chrome, Edge, Firefox or Safari on a computer, or switch on hardware acceleration in the browser's settings. Nothing is lost.",
    ],
  },
  "touch-only": {
    title: "Please use a computer",
    lines: ["You walk with the keyboard and look around with the mouse. Please open your personal link on a computer that has both. Nothing is lost."],
  },
  "context-lost": {
    title: "The graphics stopped",
    lines: ["The graphics card was taken away for a moment. The picture comes back by itself; if it does not, load the page again."],
    busy: true,
  },
});

/** Keys and what they do, in the order of the help page. */
export const CONTROLS = Object.freeze([
  { keys: ["W", "A", "S", "D"], text: "walk forward, left, back and right (the arrow keys do the same)" },
  { keys: ["Mouse"], text: "look around, after a click into the picture" },
  { keys: ["Q", "E"], text: "turn left and right without the mouse" },
  { keys: ["Esc"], text: "set the mouse free" },
  { keys: ["H"], text: "show or hide this help" },
]);
