// The robots themselves with what they carry, always there: one instanced mesh, and one of soft shadows
// under them.

import {
  Color, DynamicDrawUsage, InstancedBufferAttribute, InstancedMesh, Matrix4, MeshPhongMaterial, PlaneGeometry, ShaderMaterial,
} from "three";
import { plateCell } from "./atlas.js";
import { BOX_COLOURS, robotColour } from "./palette.js";
import { makeRobotShape } from "./robot_shape.js";
import { ORDER } from "./space.js";

/** @typedef {import("./space.js").RobotSample} RobotSample */

/** How much of the robot's colour its whole body takes when its live location is shown. */
const SHOWN_TINT = 0.8;

/** @param {import("three").Texture} atlas @param {import("three").Texture} boxFace */
function makeMaterial(atlas, boxFace) {
  const material = new MeshPhongMaterial({ shininess: 38, specular: 0x3a3f45 });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.plates = { value: atlas };
    shader.uniforms.boxFace = { value: boxFace };
    shader.vertexShader = shader.vertexShader
      .replace(
        "#include <common>",
        `#include <common>
         attribute vec3 base, team; attribute float paint, tint; attribute vec4 plate, load;
         varying vec3 vBase, vTeam, vLoad; varying float vPaint, vTint; varying vec2 vPlate;`,
      )
      .replace(
        "#include <begin_vertex>",
        `#include <begin_vertex>
         vBase = base; vTeam = team; vLoad = load.rgb; vPaint = paint; vTint = tint;
         vPlate = paint > 2.5 ? uv : mix(plate.xy, plate.zw, uv);
         if (paint > 2.5) transformed *= load.a;`,
      );
    shader.fragmentShader = shader.fragmentShader
      .replace(
        "#include <common>",
        `#include <common>
         uniform sampler2D plates, boxFace;
         varying vec3 vBase, vTeam, vLoad; varying float vPaint, vTint; varying vec2 vPlate;`,
      )
      .replace(
        "#include <map_fragment>",
        `vec3 body = mix(vBase, vTeam * (0.35 + 0.65 * min(1.0, 4.0 * max(vBase.r, vBase.b))), vTint);
         vec3 number = texture2D(plates, vPlate).rgb;
         vec4 face = texture2D(boxFace, vPlate);
         vec3 box = face.rgb * mix(vec3(1.0), vLoad, face.a);
         diffuseColor.rgb = vPaint > 2.5 ? box : (vPaint > 1.5 ? number : (vPaint > 0.5 ? vTeam : body));`,
      )
      .replace(
        "#include <emissivemap_fragment>",
        "totalEmissiveRadiance += (vPaint > 2.5 ? 0.0 : vPaint > 0.5 ? 0.16 : 0.22 * vTint) * diffuseColor.rgb;",
      )
      .replace("#include <specularmap_fragment>", "float specularStrength = vPaint > 2.5 ? 0.0 : 1.0;");
  };
  return material;
}

/** A dark soft spot on the floor. */
function makeShadowMaterial() {
  return new ShaderMaterial({
    transparent: true,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -4,
    vertexShader: `
      varying vec2 vUv;
      void main() {
        vUv = uv * 2.0 - 1.0;
        gl_Position = projectionMatrix * viewMatrix * modelMatrix * instanceMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `
      varying vec2 vUv;
      void main() {
        float d = length(vUv);
        gl_FragColor = vec4(0.0, 0.0, 0.0, 0.62 * (1.0 - smoothstep(0.3, 1.0, d)));
      }`,
  });
}

/** All robots of a trial. */
export class RobotFleet {
  /** @param {number} robots @param {import("three").Texture} atlas @param {import("three").Texture} boxFace */
  constructor(robots, atlas, boxFace) {
    this.count = robots;
    const shape = makeRobotShape();
    const team = new Float32Array(robots * 3);
    const plate = new Float32Array(robots * 4);
    for (let robot = 0; robot < robots; robot += 1) {
      new Color(robotColour(robot)).toArray(team, robot * 3);
      const rect = plateCell(robot);
      plate.set([rect.u0, rect.v0, rect.u1, rect.v1], robot * 4);
    }
    this.tint = new InstancedBufferAttribute(new Float32Array(robots), 1);
    shape.setAttribute("team", new InstancedBufferAttribute(team, 3));
    shape.setAttribute("plate", new InstancedBufferAttribute(plate, 4));
    shape.setAttribute("tint", this.tint);
    this.load = new InstancedBufferAttribute(new Float32Array(robots * 4), 4);
    shape.setAttribute("load", this.load);
    this.boxColours = BOX_COLOURS.map((hex) => new Color(hex));
    /** Colours carried as last drawn, so that they are sent to the card only when they change. */
    this.carried = new Int8Array(robots).fill(-1);
    this.mesh = new InstancedMesh(shape, makeMaterial(atlas, boxFace), robots);
    const spot = new PlaneGeometry(0.66, 0.66).rotateX(-Math.PI / 2).translate(0, 0.008, 0);
    this.shadows = new InstancedMesh(spot, makeShadowMaterial(), robots);
    for (const mesh of [this.mesh, this.shadows]) {
      mesh.frustumCulled = false;
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    }
    this.mesh.renderOrder = ORDER.robots;
    this.shadows.renderOrder = ORDER.shadows;
    this.matrix = new Matrix4();
  }

  /** @param {RobotSample[]} samples */
  update(samples) {
    const places = this.mesh.instanceMatrix.array;
    const spots = this.shadows.instanceMatrix.array;
    for (let robot = 0; robot < this.count; robot += 1) {
      const sample = samples[robot];
      if (!sample) continue;
      this.matrix.makeRotationY(sample.heading).setPosition(sample.x_m, 0, -sample.y_m);
      this.matrix.toArray(places, robot * 16);
      this.matrix.toArray(spots, robot * 16);
      this.#carry(robot, sample.carrying);
    }
    this.mesh.instanceMatrix.needsUpdate = true;
    this.shadows.instanceMatrix.needsUpdate = true;
  }

  /** @param {number} robot @param {number} colour of the box, -1 for none */
  #carry(robot, colour) {
    if (this.carried[robot] === colour) return;
    this.carried[robot] = colour;
    const { r, g, b } = this.boxColours[Math.max(0, colour)] ?? new Color();
    this.load.setXYZW(robot, r, g, b, colour < 0 ? 0 : 1);
    this.load.needsUpdate = true;
  }

  /** Paints the body of robots whose live location is shown. @param {number} robot @param {boolean} shown */
  showLive(robot, shown) {
    const value = shown ? SHOWN_TINT : 0;
    if (this.tint.array[robot] === value) return;
    this.tint.array[robot] = value;
    this.tint.needsUpdate = true;
  }
}
