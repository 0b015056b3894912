// Draws one scripted world for a picture. The world comes as JSON from the page's own server.

import { Stage } from "../../../web/static/js/scene/stage.js";
import { HallView } from "../../../web/static/js/scene/view.js";
import { Hud } from "../../../web/static/js/ui/hud.js";

const world = await (await fetch("world.json")).json();
const parent = /** @type {HTMLElement} */ (document.getElementById("stage"));
const stage = new Stage(parent, world.antialias ?? "on", () => {});
const view = new HallView(stage, {
  hall: world.hall,
  robots: world.robots.length,
  widestAt: world.widestAt ?? "goal",
  still: false,
});
for (const [robot, { corners }] of world.robots.entries()) view.setPlan(robot, corners);
view.setDisplay({
  overlays: world.display.overlays,
  robots: Uint8Array.from(world.display.robots),
  stations: Uint8Array.from(world.display.stations),
});
if (world.hud) {
  const hud = new Hud(parent, () => {});
  hud.begin(world.hud, 3 * world.robots.length);
  hud.showBoxes(14);
  hud.showTime(133);
}

/** @typedef {{ x: number, y: number, heading: number, pitch: number, now_s: number }} Shot */

const picture = {
  /** Draws the world from a place; called by the script that takes the pictures. @param {Shot} shot */
  draw(shot) {
    for (let n = 0; n < 3; n += 1) view.draw(shot, world.robots, shot.now_s + n * 0.2);
    return { calls: stage.renderer.info.render.calls, triangles: stage.renderer.info.render.triangles };
  },
  /**
   * JavaScript time per frame with the graphics card's calls replaced by nothing.
   * @param {Shot} shot @param {number} frames
   */
  measure(shot, frames) {
    const gl = /** @type {any} */ (stage.renderer.getContext());
    for (const name of ["drawArrays", "drawElements", "drawElementsInstanced", "drawArraysInstanced", "clear", "bufferSubData", "bufferData"])
      gl[name] = () => {};
    const times = [];
    for (let n = 0; n < frames; n += 1) {
      const robots = world.robots.map((/** @type {any} */ robot) => ({ ...robot, x_m: robot.x_m + 0.002 * (n % 100) }));
      const at = { ...shot, heading: shot.heading + 0.01 * n };
      const start = performance.now();
      view.draw(at, robots, shot.now_s + n / 60);
      times.push(performance.now() - start);
    }
    times.sort((a, b) => a - b);
    return { frames, median_ms: times[frames >> 1], p95_ms: times[Math.floor(frames * 0.95)], calls: stage.renderer.info.render.calls };
  },
};
Object.assign(window, { picture });
document.body.dataset.ready = "yes";
