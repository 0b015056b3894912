// The whole picture of a trial: asks what the world is now and draws it.

import { makeAtlas } from "./atlas.js";
import { Avatars } from "./avatars.js";
import { Balloons } from "./balloons.js";
import { Beads } from "./beads.js";
import { Callouts, FAINT, NORMAL, OUTSIDE } from "./callouts.js";
import { makeHall } from "./hall.js";
import { makeLights } from "./light.js";
import { Minimap } from "./minimap.js";
import { makeBoxTexture } from "./racks.js";
import { Ribbons } from "./ribbons.js";
import { RobotFleet } from "./robots.js";
import { Routes } from "./routes.js";
import { FIELD_OF_VIEW_DEG } from "./space.js";
import { Sprites } from "./sprites.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */
/** @typedef {import("./space.js").RobotSample} RobotSample */
/**
 * @typedef {object} Viewpoint plan metres and radians; without a height the human's eyes
 * @property {number} x @property {number} y @property {number} heading @property {number} pitch
 * @property {number} [height_m] @property {number} [fov_deg] @property {number} [near_m] @property {number} [far_m]
 * @property {boolean} [outside] a spectator's camera: no ceiling, no haze, no arrows at the edge
 */
/** @typedef {{ hall: HallPlan, robots: number, widestAt: "goal" | "robot", still: boolean }} ViewOptions still: no decorative motion */

/** Elements of a robot, by bit, and overlays of the whole display, as the server sends them. */
export const LIVE_LOCATION = 1;
export const TRANSPARENT_AVATAR = 2;
export const TRAJECTORY = 4;
export const PATH_BEADS = 8;
export const MINIMAP = 1;
export const OFFSCREEN_ARROWS = 2;

const MINIMAP_PX = 208;

/** Draws hall, robots and whatever the display shows. */
export class HallView {
  /** @param {import("./stage.js").Stage} stage @param {ViewOptions} options */
  constructor(stage, options) {
    const { hall, robots } = options;
    const document = stage.parent.ownerDocument;
    this.stage = stage;
    this.hall = hall;
    this.masks = new Uint8Array(robots);
    this.overlays = 0;
    const atlas = makeAtlas(document);
    const boxFace = makeBoxTexture(document);
    this.fleet = new RobotFleet(robots, atlas, boxFace);
    this.routes = new Routes(robots);
    this.ribbons = new Ribbons(options.widestAt);
    this.beads = new Beads();
    this.solid = new Avatars(robots, "solid");
    this.ghosts = new Avatars(robots, "ghost");
    this.balloons = new Balloons(hall.stations, options.still);
    this.sprites = new Sprites(atlas);
    this.callouts = new Callouts(this.sprites, robots);
    this.minimap = new Minimap(stage.parent, hall, robots, MINIMAP_PX);
    this.drawnVersion = -1;
    this.last_s = 0;
    this.isOutside = false;
    /** Whether spectators see every robot's number, not only of those whose live location is shown. */
    this.numbersAll = false;
    this.standing = makeHall(document, hall, { atlas, boxFace, longest_px: stage.longestTexture_px });
    stage.scene.add(
      ...makeLights(), ...this.standing.objects, this.fleet.mesh, this.fleet.shadows, ...this.ribbons.meshes,
      this.beads.mesh, this.solid.mesh, this.ghosts.mesh, this.balloons.mesh, this.sprites.mesh,
    );
  }

  /** @param {number} robot @param {[number, number][]} corners lattice cells; none for no path */
  setPlan(robot, corners) {
    this.routes.set(robot, corners);
  }

  /** @param {{ overlays: number, robots: Uint8Array, stations: Uint8Array }} display */
  setDisplay(display) {
    this.overlays = display.overlays;
    this.masks.set(display.robots.subarray(0, this.masks.length));
    this.masks.forEach((mask, robot) => this.fleet.showLive(robot, (mask & LIVE_LOCATION) !== 0));
    this.balloons.shown = this.hall.stations.map((_, station) => display.stations[station] === 1);
    this.minimap.show((display.overlays & MINIMAP) !== 0);
    this.routes.version += 1;
  }

  /** @param {number} robot @param {number} element */
  #shows(robot, element) {
    return ((this.masks[robot] ?? 0) & element) !== 0;
  }

  /** Draws one frame. @param {Viewpoint} at @param {RobotSample[]} robots @param {number} now_s */
  draw(at, robots, now_s) {
    const { size } = this.stage;
    const seconds = Math.min(0.25, Math.max(0, now_s - this.last_s));
    this.last_s = now_s;
    const outside = at.outside === true;
    this.stage.aim({ ...at, height_m: at.height_m ?? this.hall.eye_height_m }, outside);
    if (outside !== this.isOutside) this.standing.showFrom(outside);
    this.isOutside = outside;
    this.#moveRobots(robots);
    this.#drawElements(robots, now_s);
    this.#writeOver(at, robots, seconds);
    this.ribbons.update(this.routes, size.width, size.height, this.stage.ratio);
    this.stage.draw();
  }

  /** @param {RobotSample[]} robots */
  #moveRobots(robots) {
    this.fleet.update(robots);
    robots.forEach((sample, robot) => this.routes.follow(robot, sample.x_m, sample.y_m));
  }

  /** @param {RobotSample[]} robots @param {number} now_s */
  #drawElements(robots, now_s) {
    const eye = this.stage.camera.position;
    if (this.drawnVersion !== this.routes.version) {
      this.drawnVersion = this.routes.version;
      this.ribbons.rebuild(this.routes, (robot) => ({ trajectory: this.#shows(robot, TRAJECTORY), beads: this.#shows(robot, PATH_BEADS) }));
      this.beads.rebuild(this.routes, (robot) => this.#shows(robot, PATH_BEADS));
    }
    this.beads.update(this.routes);
    this.solid.begin();
    this.ghosts.begin();
    robots.forEach((sample, robot) => {
      this.solid.place(robot, this.#shows(robot, LIVE_LOCATION) ? 1 : 0, sample.x_m, sample.y_m, sample.heading, eye);
      const ghost = this.#shows(robot, TRANSPARENT_AVATAR) ? this.routes.ghost(robot, now_s) : null;
      if (ghost) this.ghosts.place(robot, ghost.fade, ghost.x, ghost.y, ghost.heading, eye);
      else this.ghosts.place(robot, 0, 0, 0, 0, eye);
    });
    this.solid.end();
    this.ghosts.end();
    this.balloons.update({ x: eye.x, y: -eye.z, height_m: eye.y }, now_s);
  }

  /** @param {Viewpoint} at @param {RobotSample[]} robots @param {number} seconds */
  #writeOver(at, robots, seconds) {
    const { camera, size, halfView } = this.stage;
    const widening = Math.tan((camera.fov * Math.PI) / 360) / Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
    const steepness = at.outside ? Math.max(0, -Math.sin(at.pitch)) : 0;
    const eye = { x: at.x, y: at.y, heading: at.heading, halfView, width: size.width, height: size.height, isOutside: at.outside === true, steepness, widening };
    this.sprites.begin(size.width, size.height);
    this.callouts.begin();
    robots.forEach((sample, robot) => {
      const isLive = this.#shows(robot, LIVE_LOCATION);
      if (isLive || this.numbersAll) this.callouts.addRobot(camera, eye, robot, sample, isLive ? (at.outside ? OUTSIDE : NORMAL) : FAINT);
    });
    this.balloons.places.forEach((place, station) => {
      if (this.balloons.shown[station]) this.callouts.addBalloon(camera, eye, station, place, robots.length + station);
    });
    this.callouts.drawLabels(seconds);
    if (this.overlays & OFFSCREEN_ARROWS && !at.outside) this.callouts.drawArrows(eye, robots, this.minimap.disc(size.height));
    this.sprites.end();
    this.minimap.draw(eye, robots);
  }
}
