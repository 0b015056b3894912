// The planned path of every robot as the scene keeps it, with what each part of the scene asks of it.

import { cornersInMetres, pathLength, pointAlong, progressAlong, roundPath } from "./paths.js";

/** @typedef {import("./paths.js").PathPoint} PathPoint */
/** @typedef {{ corners: [number, number][], path: PathPoint[], progress_m: number }} Route */

/** Metres per second of a ghost, its rest at the goal in seconds, and how long it takes to fade. */
const GHOST_SPEED_MPS = 2.2;
const GHOST_REST_S = 0.7;
const GHOST_FADE_S = 0.35;

/** Routes of all robots, and a version that rises whenever their drawing must be made anew. */
export class Routes {
  /** @param {number} robots */
  constructor(robots) {
    /** @type {Route[]} */
    this.routes = Array.from({ length: robots }, () => ({ corners: [], path: [], progress_m: 0 }));
    this.version = 0;
  }

  /** @param {number} robot @param {[number, number][]} cells corner cells; none for no path */
  set(robot, cells) {
    const route = this.routes[robot];
    if (!route) return;
    route.corners = cornersInMetres(cells);
    route.path = route.corners.length > 1 ? roundPath(route.corners) : [];
    route.progress_m = 0;
    this.version += 1;
  }

  /** @param {number} robot */
  get(robot) {
    return /** @type {Route} */ (this.routes[robot]);
  }

  /** @param {number} robot @param {number} x @param {number} y metres */
  follow(robot, x, y) {
    const route = this.routes[robot];
    if (route?.path.length) route.progress_m = progressAlong(route.path, x, y, route.progress_m);
  }

  /**
   * Where a robot's ghost is now; it starts at the robot and glides to the goal, again and again.
   * @param {number} robot @param {number} now_s
   * @returns {{ x: number, y: number, heading: number, fade: number } | null} null without a path
   */
  ghost(robot, now_s) {
    const route = this.routes[robot];
    if (!route?.path.length) return null;
    const ahead = pathLength(route.path) - route.progress_m;
    if (ahead < 0.25) return null;
    const glide_s = pathLength(route.path) / GHOST_SPEED_MPS;
    const cycle_s = glide_s + GHOST_REST_S;
    const phase_s = (now_s + robot * 0.37) % cycle_s;
    const share = Math.min(1, phase_s / glide_s);
    const place = pointAlong(route.path, route.progress_m + share * ahead);
    const fade = Math.min(1, phase_s / GHOST_FADE_S, (cycle_s - phase_s) / GHOST_FADE_S);
    return { ...place, fade: Math.max(0, fade) };
  }
}
