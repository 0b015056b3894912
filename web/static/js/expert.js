// Entry of the expert's page of a learning run.

import { showEndedRun } from "./ended_run.js";
import { listenToKeys, offerCopies } from "./expert_keys.js";
import { ExpertRun } from "./expert_run.js";
import { makeClient } from "./net/expert_messages.js";
import { NoWebGlError } from "./scene/stage.js";
import { Notices } from "./ui/notices.js";

function start() {
  offerCopies(document);
  const { live = "", antialias = "auto", status } = document.body.dataset;
  const address = new URL(live, location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  if (status !== "open") {
    showEndedRun(document, address.href, makeClient());
    return;
  }
  const page = new URL(live, location.href).pathname.replace(/\/live$/, "");
  try {
    const run = new ExpertRun(document, { live: address.href, page, antialias: antialias === "on" || antialias === "off" ? antialias : "auto" });
    listenToKeys(document, run);
  } catch (error) {
    if (!(error instanceof NoWebGlError)) throw error;
    const place = /** @type {HTMLElement} */ (document.getElementById("notices"));
    new Notices(place).showBanner("refused", "3D graphics are not available", [
      "This browser cannot draw the warehouse, because WebGL 2 is missing or switched off.",
      "Please open this page in a current Chrome, Edge, Firefox or Safari, or switch on hardware acceleration in the browser's settings.",
    ]);
  }
}

start();
