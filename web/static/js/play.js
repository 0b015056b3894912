// Entry of the trial's page.

import { NoWebGlError } from "./scene/stage.js";
import { Trial } from "./trial.js";
import { Overlays } from "./ui/overlays.js";

/** Whether the device can only be touched: nobody could walk here. */
function isTouchOnly() {
  return navigator.maxTouchPoints > 0 && !matchMedia("(any-pointer: fine)").matches;
}

function start() {
  const element = document.getElementById("stage");
  if (!element) throw new Error("The page has no element with the id “stage”.");
  const { live = "", next = location.pathname, antialias = "auto" } = document.body.dataset;
  const address = new URL(live, location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  if (isTouchOnly()) {
    new Overlays(element).show("touch-only");
    return;
  }
  try {
    new Trial(element, { live: address.href, next, antialias: antialias === "on" || antialias === "off" ? antialias : "auto" });
  } catch (error) {
    if (!(error instanceof NoWebGlError)) throw error;
    element.replaceChildren();
    new Overlays(element).show("no-webgl");
  }
}

start();
