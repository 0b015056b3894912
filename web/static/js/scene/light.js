// The hall's light: rows of panels under the ceiling, a bright sky of them from above, a little from
// the side so that edges read, and a thin haze far away.

import { DirectionalLight, HemisphereLight } from "three";

/** Distance between light panels along x and y, and half the size of one, in metres. */
export const PANEL_PITCH_M = /** @type {[number, number]} */ ([4.2, 3.6]);
export const PANEL_HALF_M = /** @type {[number, number]} */ ([1.0, 0.16]);

export const FOG_COLOUR = "#c3cbd1";
export const FOG_DENSITY = 0.0105;
/** Round the hall for those who look in from outside. */
export const OUTSIDE_COLOUR = "#0d1318";

/** @returns {import("three").Light[]} */
export function makeLights() {
  const sky = new HemisphereLight("#ffffff", "#b4b0a8", 2.75);
  const key = new DirectionalLight("#fff4e2", 0.95);
  key.position.set(0.55, 1, 0.4);
  const rim = new DirectionalLight("#dbe8ff", 0.5);
  rim.position.set(-0.6, 0.5, -0.75);
  return [sky, key, rim];
}
