// Spheres at the turning points of the planned paths, one instanced mesh; those a robot has passed
// shrink away.

import { Color, DynamicDrawUsage, InstancedBufferAttribute, InstancedMesh, Matrix4, ShaderMaterial, SphereGeometry } from "three";
import { robotColour } from "./palette.js";
import { progressAlong } from "./paths.js";
import { laneOffset } from "./ribbon_geometry.js";
import { ORDER } from "./space.js";

/** @typedef {import("./routes.js").Routes} Routes */

const BEADS_MAX = 900;
const RADIUS_M = 0.105;
const HEIGHT_M = 0.13;

const VERTEX = `
attribute vec3 team;
varying vec3 vTeam, vNormalView;
void main() {
  vTeam = team;
  vec4 middle = viewMatrix * instanceMatrix * vec4(0.0, 0.0, 0.0, 1.0);
  float grow = 1.0 + clamp((-middle.z - 10.0) * 0.05, 0.0, 1.6);
  vNormalView = normalize(normalMatrix * normal);
  gl_Position = projectionMatrix * viewMatrix * instanceMatrix * vec4(position * grow, 1.0);
}`;

const FRAGMENT = `
varying vec3 vTeam, vNormalView;
void main() {
  vec3 n = normalize(vNormalView);
  float lamp = 0.62 + 0.45 * max(dot(n, normalize(vec3(0.25, 0.85, 0.45))), 0.0);
  float shine = pow(max(dot(n, normalize(vec3(0.2, 0.7, 0.7))), 0.0), 24.0);
  float rim = smoothstep(0.5, 0.25, n.z);
  vec3 colour = mix(vTeam * lamp + 0.5 * shine, vec3(1.0), 0.8 * rim);
  gl_FragColor = vec4(colour, 0.95);
  #include <colorspace_fragment>
}`;

/** Beads of all robots. */
export class Beads {
  constructor() {
    const shape = new SphereGeometry(RADIUS_M, 16, 12);
    this.team = new InstancedBufferAttribute(new Float32Array(BEADS_MAX * 3), 3);
    shape.setAttribute("team", this.team);
    const material = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthTest: false, depthWrite: false });
    this.mesh = new InstancedMesh(shape, material, BEADS_MAX);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = ORDER.beads;
    /** @type {{ robot: number, at_m: number, x: number, y: number, passed: boolean }[]} */
    this.beads = [];
    this.matrix = new Matrix4();
    this.colour = new Color();
  }

  /** @param {Routes} routes @param {(robot: number) => boolean} shown */
  rebuild(routes, shown) {
    this.beads = [];
    routes.routes.forEach((route, robot) => {
      if (!route.path.length || !shown(robot)) return;
      let at_m = 0;
      route.corners.forEach(([x, y], n) => {
        if (n === 0) return;
        const [fromX, fromY] = route.corners[n - 1] ?? [x, y];
        at_m = progressAlong(route.path, x, y, at_m, Math.hypot(x - fromX, y - fromY));
        const [nextX, nextY] = route.corners[n + 1] ?? [x, y];
        const heading = Math.atan2(nextY - fromY, nextX - fromX);
        const lane = laneOffset(robot);
        this.beads.push({ robot, at_m, x: x - Math.sin(heading) * lane, y: y + Math.cos(heading) * lane, passed: false });
      });
    });
    this.beads.length = Math.min(this.beads.length, BEADS_MAX);
    this.beads.forEach((bead, n) => {
      this.colour.set(robotColour(bead.robot)).toArray(this.team.array, 3 * n);
      this.#place(n, 1);
    });
    this.mesh.count = this.beads.length;
    this.mesh.visible = this.beads.length > 0;
    this.team.needsUpdate = true;
  }

  /** @param {number} n @param {number} size */
  #place(n, size) {
    const bead = this.beads[n];
    if (!bead) return;
    this.matrix.makeScale(size, size, size).setPosition(bead.x, HEIGHT_M, -bead.y);
    this.mesh.setMatrixAt(n, this.matrix);
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  /** @param {Routes} routes */
  update(routes) {
    this.beads.forEach((bead, n) => {
      const passed = routes.get(bead.robot).progress_m > bead.at_m - 0.15;
      if (passed === bead.passed) return;
      bead.passed = passed;
      this.#place(n, passed ? 0 : 1);
    });
  }
}
