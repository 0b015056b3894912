// The human as spectators see them: a plain figure, and on the floor the way they look.

import { BufferAttribute, BufferGeometry, CapsuleGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry } from "three";
import { ORDER } from "./space.js";

const VEST = "#ff7a1a";
const HEAD = "#f0d2b6";
const GLASSES = "#1b2733";
const WEDGE_M = 3.2;
const WEDGE_HALF_RAD = 0.62;
const WEDGE_STEPS = 12;

/** A fan on the floor that fades outwards, along +x. */
function makeWedge() {
  const positions = [0, 0, 0];
  const colours = [1, 0.75, 0.35, 0.62];
  /** @type {number[]} */
  const indices = [];
  for (let n = 0; n <= WEDGE_STEPS; n += 1) {
    const angle = WEDGE_HALF_RAD * (1 - (2 * n) / WEDGE_STEPS);
    positions.push(Math.cos(angle) * WEDGE_M, 0, -Math.sin(angle) * WEDGE_M);
    colours.push(1, 0.75, 0.35, 0);
    if (n) indices.push(0, n, n + 1);
  }
  const shape = new BufferGeometry();
  shape.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  shape.setAttribute("color", new BufferAttribute(new Float32Array(colours), 4));
  shape.setIndex(indices);
  const material = new MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false, depthTest: false, side: DoubleSide, fog: false });
  const mesh = new Mesh(shape, material);
  mesh.position.y = 0.03;
  mesh.renderOrder = ORDER.ribbons;
  return mesh;
}

/** The worker's figure. */
export class Person {
  constructor() {
    const paint = (/** @type {string} */ color) => new MeshLambertMaterial({ color, emissive: color, emissiveIntensity: 0.25 });
    const body = new Mesh(new CapsuleGeometry(0.25, 0.95, 4, 14), paint(VEST));
    body.position.y = 0.73;
    const head = new Mesh(new SphereGeometry(0.16, 16, 12), paint(HEAD));
    head.position.y = 1.62;
    const glasses = new Mesh(new SphereGeometry(0.1, 12, 8), paint(GLASSES));
    glasses.scale.set(0.7, 0.6, 1.5);
    glasses.position.set(0.11, 1.65, 0);
    this.object = new Group();
    this.object.add(makeWedge(), body, head, glasses);
    this.object.visible = false;
  }

  /** @param {{ x: number, y: number, heading: number }} at plan metres, radians @param {boolean} visible @param {number} size 1 for true to scale */
  place(at, visible, size) {
    this.object.scale.setScalar(size);
    this.object.visible = visible;
    this.object.position.set(at.x, 0, -at.y);
    this.object.rotation.y = at.heading;
  }
}
