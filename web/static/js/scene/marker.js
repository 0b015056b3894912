// A ring on the floor round the robot or station that a spectator has chosen.

import { DoubleSide, Mesh, MeshBasicMaterial, RingGeometry } from "three";
import { ORDER } from "./space.js";

const ROBOT_M = 0.62;
const STATION_M = 1.15;

/** White with a dark edge: seen on every floor and against every robot's colour. */
export class Marker {
  constructor() {
    const ring = (/** @type {number} */ inner, /** @type {number} */ outer, /** @type {string} */ color) => {
      const shape = new RingGeometry(inner, outer, 40).rotateX(-Math.PI / 2);
      const mesh = new Mesh(shape, new MeshBasicMaterial({ color, side: DoubleSide, transparent: true, opacity: 0.9, depthTest: false, depthWrite: false, fog: false }));
      mesh.renderOrder = ORDER.beads;
      return mesh;
    };
    this.object = ring(0.8, 1, "#ffffff");
    this.object.add(ring(1, 1.1, "#10151c"), ring(0.72, 0.8, "#10151c"));
    this.object.visible = false;
  }

  hide() {
    this.object.visible = false;
  }

  /** @param {{ x: number, y: number }} at plan metres @param {boolean} isStation */
  place(at, isStation) {
    const size = isStation ? STATION_M : ROBOT_M;
    this.object.visible = true;
    this.object.position.set(at.x, 0.04, -at.y);
    this.object.scale.set(size, 1, size);
  }
}
