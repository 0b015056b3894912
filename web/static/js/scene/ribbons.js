// All ribbons and bead lines as one mesh. It is rebuilt only when a plan or the display changes; the
// part a robot has left behind is cut off in the shader by its progress.

import {
  BufferAttribute, BufferGeometry, Color, CustomBlending, DynamicDrawUsage, GreaterDepth, Mesh,
  OneMinusSrcAlphaFactor, ShaderMaterial, SrcAlphaFactor, Vector2,
} from "three";
import { robotColour } from "./palette.js";
import { buildBand, laneOffset, ribbonWidth } from "./ribbon_geometry.js";
import { ORDER, RIBBON_M } from "./space.js";

/** @typedef {import("./routes.js").Routes} Routes */
/** @typedef {{ trajectory: boolean, beads: boolean }} PathLook */

export const ROBOTS_MAX = 32;
const VERTICES_MAX = 24000;
const BEAD_LINE_M = 0.065;
/** A ribbon stops short of the robot that drives it. */
const CLEARANCE_M = 0.2;
/** The faint part shows only behind things at least this far before it. */
const HIDDEN_BY_M = 0.15;

const VERTEX = `
attribute vec2 side;
attribute vec3 team;
attribute vec4 band;
uniform vec2 viewport;
uniform float leastHalf_px, ahead;
varying vec3 vTeam;
varying vec4 vBand;
void main() {
  vec4 middle = projectionMatrix * viewMatrix * vec4(position, 1.0);
  vec4 edge = projectionMatrix * viewMatrix * vec4(position + vec3(side.x, 0.0, -side.y), 1.0);
  float stretch = 1.0;
  if (middle.w > 0.3 && edge.w > 0.3) {
    float half_px = 0.5 * length((edge.xy / edge.w - middle.xy / middle.w) * viewport);
    stretch = clamp(leastHalf_px / max(half_px, 0.001), 1.0, 7.0);
  }
  vTeam = team;
  vBand = band;
  vec4 eye = viewMatrix * vec4(position + stretch * vec3(side.x, 0.0, -side.y), 1.0);
  gl_Position = projectionMatrix * eye;
  if (ahead > 0.0) {
    vec4 nearer = projectionMatrix * vec4(eye.xyz * (1.0 - ahead / max(length(eye.xyz), ahead + 0.2)), 1.0);
    gl_Position.z = nearer.z / nearer.w * gl_Position.w;
  }
}`;

const FRAGMENT = `
uniform float progress[${ROBOTS_MAX}];
uniform float strength;
varying vec3 vTeam;
varying vec4 vBand;
void main() {
  float cut = vBand.y - progress[int(vBand.z + 0.5)] - ${CLEARANCE_M.toFixed(2)};
  if (cut < 0.0) discard;
  float off = abs(vBand.x);
  float soft = clamp(fwidth(vBand.x), 0.02, 1.0);
  float edge = 1.0 - smoothstep(1.0 - soft, 1.0, off);
  float keyline = vBand.w > 0.5 ? 0.0 : smoothstep(0.72, 0.72 + soft, off) * (1.0 - smoothstep(0.25, 0.6, soft));
  vec3 colour = mix(vTeam, vec3(1.0), 0.75 * keyline);
  float alpha = mix(0.9, 0.85, keyline) * max(edge, 0.35 * step(0.6, soft)) * min(1.0, cut / 0.15);
  gl_FragColor = vec4(colour, alpha * strength);
  #include <colorspace_fragment>
}`;

/** @param {number} strength @param {boolean} hidden draws only what something stands before */
function makeMaterial(strength, hidden) {
  const material = new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    // Opaque things are drawn first: so the faint part comes before the robots, which cover it.
    transparent: !hidden,
    ...(hidden ? { blending: CustomBlending, blendSrc: SrcAlphaFactor, blendDst: OneMinusSrcAlphaFactor } : {}),
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -4,
    uniforms: {
      progress: { value: new Float32Array(ROBOTS_MAX) },
      strength: { value: strength },
      viewport: { value: new Vector2(1, 1) },
      leastHalf_px: { value: 1.5 },
      ahead: { value: hidden ? HIDDEN_BY_M : 0 },
    },
  });
  if (hidden) material.depthFunc = GreaterDepth;
  return material;
}

/** The ribbons of all robots: one mesh in sight, the same faintly where hidden. */
export class Ribbons {
  /** @param {"goal" | "robot"} widestAt */
  constructor(widestAt) {
    this.widestAt = widestAt;
    this.geometry = new BufferGeometry();
    /** @type {Record<string, BufferAttribute>} */
    this.attributes = {};
    for (const [name, size] of /** @type {[string, number][]} */ ([["position", 3], ["side", 2], ["team", 3], ["band", 4]])) {
      const attribute = new BufferAttribute(new Float32Array(VERTICES_MAX * size), size);
      attribute.setUsage(DynamicDrawUsage);
      this.attributes[name] = attribute;
      this.geometry.setAttribute(name, attribute);
    }
    this.geometry.setIndex(new BufferAttribute(new Uint32Array(VERTICES_MAX * 3), 1));
    this.seen = makeMaterial(1, false);
    this.hidden = makeMaterial(0.38, true);
    this.hidden.uniforms.progress = this.seen.uniforms.progress ?? { value: null };
    this.hidden.uniforms.viewport = this.seen.uniforms.viewport ?? { value: null };
    this.hidden.uniforms.leastHalf_px = this.seen.uniforms.leastHalf_px ?? { value: 1.5 };
    this.meshes = [new Mesh(this.geometry, this.hidden), new Mesh(this.geometry, this.seen)];
    this.meshes.forEach((mesh, n) => {
      mesh.frustumCulled = false;
      mesh.renderOrder = n === 0 ? ORDER.hiddenRibbons : ORDER.ribbons;
    });
    this.used = { vertices: 0, indices: 0 };
    this.colour = new Color();
  }

  /** Draws all paths anew. @param {Routes} routes @param {(robot: number) => PathLook} look */
  rebuild(routes, look) {
    this.used = { vertices: 0, indices: 0 };
    routes.routes.forEach((route, robot) => {
      if (!route.path.length) return;
      const { trajectory, beads } = look(robot);
      if (trajectory) this.#append(buildBand(route.path, (m) => ribbonWidth(m, this.widestAt), laneOffset(robot)), robot, 0);
      if (beads) this.#append(buildBand(route.path, () => BEAD_LINE_M, laneOffset(robot)), robot, 1);
    });
    this.geometry.setDrawRange(0, this.used.indices);
    for (const attribute of Object.values(this.attributes)) attribute.needsUpdate = true;
    const index = this.geometry.getIndex();
    if (index) index.needsUpdate = true;
    for (const mesh of this.meshes) mesh.visible = this.used.indices > 0;
  }

  /** @param {import("./ribbon_geometry.js").Band} band @param {number} robot @param {number} style 0 ribbon, 1 bead line */
  #append(band, robot, style) {
    const count = band.across.length;
    const first = this.used.vertices;
    if (first + count > VERTICES_MAX) return;
    const height = RIBBON_M + 0.0012 * robot + 0.003 * style;
    this.colour.set(robotColour(robot));
    const { position, side, team, band: strip } = this.attributes;
    for (let n = 0; n < count; n += 1) {
      position?.setXYZ(first + n, band.centres[2 * n] ?? 0, height, -(band.centres[2 * n + 1] ?? 0));
      side?.setXY(first + n, band.sides[2 * n] ?? 0, band.sides[2 * n + 1] ?? 0);
      team?.setXYZ(first + n, this.colour.r, this.colour.g, this.colour.b);
      strip?.setXYZW(first + n, band.across[n] ?? 0, band.along[n] ?? 0, robot, style);
    }
    const index = /** @type {Uint32Array} */ (this.geometry.getIndex()?.array);
    band.indices.forEach((value, n) => (index[this.used.indices + n] = first + value));
    this.used.vertices += count;
    this.used.indices += band.indices.length;
  }

  /** @param {Routes} routes @param {number} width_px @param {number} height_px @param {number} pixelRatio */
  update(routes, width_px, height_px, pixelRatio) {
    const { progress, viewport, leastHalf_px } = this.seen.uniforms;
    routes.routes.forEach((route, robot) => {
      if (robot < ROBOTS_MAX) progress.value[robot] = route.progress_m;
    });
    viewport.value.set(width_px * pixelRatio, height_px * pixelRatio);
    leastHalf_px.value = 1.5 * pixelRatio;
  }
}
