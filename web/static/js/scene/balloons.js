// Big red balloons above drop stations, on a string, seen over and through everything.

import { BufferAttribute, Color, CylinderGeometry, DynamicDrawUsage, InstancedMesh, LatheGeometry, Matrix4, ShaderMaterial, Vector2 } from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { BALLOON_COLOUR } from "./palette.js";
import { ORDER } from "./space.js";

/** @typedef {import("./space.js").StationPlan} StationPlan */

/** Height of the balloon's middle; beyond the near distance it grows so that it stays a landmark. */
export const BALLOON_M = 3.35;
const NEAR_M = 9;
const GROWTH_PER_M = 0.06;
const GROWTH_MAX = 4;
const BOB_M = 0.07;
/** Beside a station the balloon sinks and shrinks, so that it stays in a view that looks straight ahead. */
const SHRINKS_WITHIN_M = 3.2;
const SIZE_MIN = 0.5;
const LOWEST_M = 1.9;
const RISE_PER_M = 0.5;

const VERTEX = `
attribute float string;
varying vec3 vNormalView, vToEye;
varying float vString;
void main() {
  vec4 world = instanceMatrix * vec4(position, 1.0);
  world.y = mix(world.y, max(world.y, 0.4), string);
  vec4 eye = viewMatrix * world;
  vString = string;
  vNormalView = normalize((viewMatrix * vec4(normal, 0.0)).xyz);
  vToEye = normalize(-eye.xyz);
  gl_Position = projectionMatrix * eye;
}`;

const FRAGMENT = `
uniform vec3 tint;
varying vec3 vNormalView, vToEye;
varying float vString;
void main() {
  vec3 n = normalize(vNormalView);
  vec3 up = normalize((viewMatrix * vec4(0.3, 1.0, 0.25, 0.0)).xyz);
  float facing = max(dot(n, normalize(vToEye)), 0.0);
  vec3 colour = tint * (0.55 + 0.55 * max(dot(n, up), 0.0) + 0.1 * facing);
  colour += vec3(1.0, 0.5, 0.5) * 0.25 * pow(1.0 - facing, 3.0);
  vec3 middle = normalize(up + normalize(vToEye));
  colour += 0.75 * smoothstep(0.945, 0.975, dot(n, middle)) + 0.16 * pow(max(dot(n, middle), 0.0), 12.0);
  gl_FragColor = vec4(mix(colour, vec3(0.93), vString), 0.97);
  #include <colorspace_fragment>
}`;

/** A balloon around the origin, knot and string below. */
function makeShape() {
  /** @type {Vector2[]} */
  const profile = [new Vector2(0, -0.66), new Vector2(0.06, -0.655), new Vector2(0.035, -0.615)];
  for (let n = 1; n <= 18; n += 1) {
    const angle = -Math.PI / 2 + (Math.PI * n) / 18;
    const low = Math.max(0, -Math.sin(angle));
    profile.push(new Vector2(Math.max(0, 0.5 * Math.cos(angle) * (1 - 0.2 * low)), 0.56 * Math.sin(angle) * (1 + 0.1 * low)));
  }
  const body = new LatheGeometry(profile, 28);
  const string = new CylinderGeometry(0.008, 0.008, 2.4, 5, 1, true).translate(0, -1.85, 0);
  for (const [shape, value] of /** @type {[import("three").BufferGeometry, number][]} */ ([[string, 1], [body, 0]])) {
    shape.deleteAttribute("uv");
    shape.setAttribute("string", new BufferAttribute(new Float32Array(shape.getAttribute("position").count).fill(value), 1));
  }
  return mergeGeometries([string, body]);
}

/** Size by distance: small beside the station, large far away. @param {number} far_m */
export function balloonSize(far_m) {
  const near = Math.max(SIZE_MIN, Math.min(1, far_m / SHRINKS_WITHIN_M));
  return Math.min(GROWTH_MAX, near + Math.max(0, far_m - NEAR_M) * GROWTH_PER_M);
}

/** Height of the middle, such that the top stays below the upper edge of a level view. @param {number} far_m @param {number} eye_m */
export function balloonHeight_m(far_m, eye_m) {
  const size = balloonSize(far_m);
  const seen = eye_m + far_m * RISE_PER_M - 0.62 * size;
  return Math.min(2.6 + 0.75 * size, Math.max(LOWEST_M, seen));
}

/** One balloon per station, hidden until shown. */
export class Balloons {
  /** @param {StationPlan[]} stations @param {boolean} still no bobbing */
  constructor(stations, still) {
    this.stations = stations;
    this.still = still;
    this.shown = stations.map(() => false);
    const material = new ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthTest: false, depthWrite: false,
      uniforms: { tint: { value: new Color(BALLOON_COLOUR) } },
    });
    this.mesh = new InstancedMesh(makeShape(), material, stations.length);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = ORDER.balloons;
    this.matrix = new Matrix4();
    /** Middle of each balloon and its size, as last drawn. */
    this.places = stations.map(({ center_m: [x, y] }) => ({ x, y, height_m: BALLOON_M, size: 1 }));
  }

  /** Far ones are drawn first. @param {{ x: number, y: number, height_m: number }} eye plan metres @param {number} now_s */
  update(eye, now_s) {
    const far = (/** @type {number} */ n) => {
      const place = this.places[n];
      return place ? Math.hypot(place.x - eye.x, place.y - eye.y) : 0;
    };
    const order = this.stations.map((_, n) => n).filter((n) => this.shown[n]).sort((a, b) => far(b) - far(a));
    order.forEach((station, n) => {
      const place = this.places[station];
      if (!place) return;
      place.size = balloonSize(far(station));
      const bob = this.still ? 0 : Math.sin(now_s * 1.6 + station) * BOB_M;
      place.height_m = balloonHeight_m(far(station), eye.height_m) + bob;
      this.matrix.makeScale(place.size, place.size, place.size).setPosition(place.x, place.height_m, -place.y);
      this.mesh.setMatrixAt(n, this.matrix);
    });
    this.mesh.count = order.length;
    this.mesh.visible = order.length > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
