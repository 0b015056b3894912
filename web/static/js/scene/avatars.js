// Two drawings of a robot that no rack can hide: the solid avatar at its true place (drawn only where
// something stands before it; in plain sight the robot itself, drawn later, wears the colour), and the ghost that
// glides along its planned path again and again.

import {
  Color, CustomBlending, DynamicDrawUsage, GreaterDepth, InstancedBufferAttribute, InstancedMesh,
  LessEqualDepth, Matrix4, OneMinusSrcAlphaFactor, ShaderMaterial, SrcAlphaFactor, Vector3,
} from "three";
import { robotColour } from "./palette.js";
import { makeBellShape } from "./robot_shape.js";
import { ORDER } from "./space.js";

/** From this distance on avatars are drawn larger, so that they stay visible. */
const NEAR_M = 12;
const GROWTH_PER_M = 0.045;
const GROWTH_MAX = 2.2;
/** A solid avatar shows only where something stands at least this far before it. */
const CLEARANCE_M = 0.1;

const VERTEX = `
attribute vec3 team;
attribute float fade;
uniform float ahead;
varying vec3 vTeam, vNormalView, vToEye;
varying float vFade, vHeight;
void main() {
  vec4 world = modelMatrix * instanceMatrix * vec4(position, 1.0);
  vec4 eye = viewMatrix * world;
  vTeam = team;
  vFade = fade;
  vHeight = position.y;
  vNormalView = normalize((viewMatrix * modelMatrix * instanceMatrix * vec4(normal, 0.0)).xyz);
  vToEye = normalize(-eye.xyz);
  gl_Position = projectionMatrix * eye;
  vec4 nearer = projectionMatrix * vec4(eye.xyz * (1.0 - ahead / max(length(eye.xyz), ahead + 0.2)), 1.0);
  gl_Position.z = nearer.z / nearer.w * gl_Position.w;
}`;

const SOLID = `
varying vec3 vTeam, vNormalView, vToEye;
varying float vFade, vHeight;
void main() {
  vec3 n = normalize(vNormalView);
  float facing = max(dot(n, normalize(vToEye)), 0.0);
  float lamp = 0.74 + 0.34 * max(n.y, 0.0);
  float band = smoothstep(0.006, 0.0, abs(vHeight - 0.068) - 0.018) + smoothstep(0.006, 0.0, abs(vHeight - 0.4) - 0.012);
  float tower = smoothstep(0.13, 0.15, vHeight) * smoothstep(0.37, 0.36, vHeight);
  vec3 colour = mix(vTeam * lamp * (1.0 - 0.3 * tower), vec3(1.0), 0.6 * min(1.0, band));
  float rim = pow(1.0 - facing, 2.0);
  colour = mix(colour, vec3(1.0), 0.75 * smoothstep(0.45, 0.8, rim));
  gl_FragColor = vec4(colour, 0.95 * vFade);
  #include <colorspace_fragment>
}`;

const GHOST = `
varying vec3 vTeam, vNormalView, vToEye;
varying float vFade, vHeight;
void main() {
  float facing = max(dot(normalize(vNormalView), normalize(vToEye)), 0.0);
  float rim = pow(1.0 - facing, 1.6);
  float band = smoothstep(0.008, 0.0, abs(vHeight - 0.068) - 0.014) + smoothstep(0.008, 0.0, abs(vHeight - 0.4) - 0.012);
  float alpha = 0.36 + 0.5 * rim + 0.35 * min(1.0, band);
  vec3 colour = mix(vTeam, vec3(1.0), 0.12 + 0.4 * rim);
  gl_FragColor = vec4(colour, min(0.9, alpha) * vFade);
  #include <colorspace_fragment>
}`;

/** @param {boolean} ghost */
function makeMaterial(ghost) {
  return new ShaderMaterial({
    uniforms: { ahead: { value: ghost ? 0 : CLEARANCE_M } },
    vertexShader: VERTEX,
    fragmentShader: ghost ? GHOST : SOLID,
    // Solid ones are drawn among opaque things, before the robots: a robot in front covers them.
    transparent: ghost,
    ...(ghost ? {} : { blending: CustomBlending, blendSrc: SrcAlphaFactor, blendDst: OneMinusSrcAlphaFactor }),
    depthWrite: false,
    depthTest: !ghost,
    depthFunc: ghost ? LessEqualDepth : GreaterDepth,
  });
}

/** A set of avatars of one kind, one per robot, hidden until placed. */
export class Avatars {
  /** @param {number} robots @param {"solid" | "ghost"} kind */
  constructor(robots, kind) {
    const shape = makeBellShape();
    const team = new Float32Array(robots * 3);
    for (let robot = 0; robot < robots; robot += 1) new Color(robotColour(robot)).toArray(team, robot * 3);
    this.fade = new InstancedBufferAttribute(new Float32Array(robots), 1);
    this.fade.setUsage(DynamicDrawUsage);
    shape.setAttribute("team", new InstancedBufferAttribute(team, 3));
    shape.setAttribute("fade", this.fade);
    this.mesh = new InstancedMesh(shape, makeMaterial(kind === "ghost"), robots);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = kind === "ghost" ? ORDER.ghosts : ORDER.solidAvatars;
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.matrix = new Matrix4();
    this.scale = new Vector3();
    this.shown = 0;
  }

  begin() {
    this.shown = 0;
  }

  /** @param {number} robot @param {number} fade 0..1; 0 hides it @param {number} x @param {number} y @param {number} heading @param {Vector3} eye */
  place(robot, fade, x, y, heading, eye) {
    this.fade.array[robot] = fade;
    const far = Math.hypot(x - eye.x, -y - eye.z);
    const size = fade <= 0 ? 0 : Math.min(GROWTH_MAX, 1 + Math.max(0, far - NEAR_M) * GROWTH_PER_M);
    if (fade > 0) this.shown += 1;
    this.matrix.makeRotationY(heading).scale(this.scale.set(size, size, size)).setPosition(x, 0.004, -y);
    this.matrix.toArray(this.mesh.instanceMatrix.array, robot * 16);
  }

  end() {
    this.mesh.visible = this.shown > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.fade.needsUpdate = true;
  }
}
