// Entry of the pages that show one trial to staff, as it runs or as it was.

import { WatchedTrial } from "./watched_trial.js";

const { live = "", kind = "live", replay = "", antialias = "auto" } = document.body.dataset;
const address = new URL(live, location.href);
address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
new WatchedTrial(document, {
  live: address.href,
  replay,
  isReplay: kind === "replay",
  antialias: antialias === "on" || antialias === "off" ? antialias : "auto",
});
