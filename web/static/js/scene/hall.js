// Everything in the hall that never moves, as three draw calls: floor, steel and walls, boxes.

import { Mesh, MeshLambertMaterial } from "three";
import { MeshBuilder } from "./builder.js";
import { makeFloor } from "./floor.js";
import { FOG_DENSITY } from "./light.js";
import { addRacks, makeBoxes } from "./racks.js";
import { addCeiling, addShell } from "./shell.js";
import { addStations } from "./stations.js";
import { addWallFeatures } from "./wall_features.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */

/**
 * Lit by the hall's lamps, darker towards the floor, with a glow of its own where a vertex has one.
 * @param {import("three").Texture} atlas
 */
function makeMaterial(atlas) {
  const material = new MeshLambertMaterial({ vertexColors: true, map: atlas });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float glow;\nvarying float vGlow;\nvarying float vHeight;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvGlow = glow;\nvHeight = position.y;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying float vGlow;\nvarying float vHeight;")
      .replace(
        "#include <emissivemap_fragment>",
        `totalEmissiveRadiance += diffuseColor.rgb * vGlow;
         diffuseColor.rgb *= 0.62 + 0.38 * smoothstep(-0.1, 0.9, vHeight);
         diffuseColor.rgb *= 1.0 - 0.35 * smoothstep(3.4, 5.4, vHeight);`,
      );
  };
  return material;
}

/** @typedef {{ atlas: import("three").Texture, boxFace: import("three").Texture, longest_px: number }} Textures longest_px: the longest side one may have */

/**
 * @typedef {object} StandingHall
 * @property {import("three").Object3D[]} objects
 * @property {(outside: boolean) => void} showFrom without ceiling and haze for a view from outside
 */

/** @param {Document} document @param {HallPlan} hall @param {Textures} textures @returns {StandingHall} */
export function makeHall(document, hall, { atlas, boxFace, longest_px }) {
  const builder = new MeshBuilder();
  addShell(builder, hall);
  addStations(builder, hall);
  addWallFeatures(builder, hall);
  addRacks(builder, hall);
  const openIndices = builder.indices.length;
  addCeiling(builder, hall);
  const steel = new Mesh(builder.build(), makeMaterial(atlas));
  const { floor, setHaze } = makeFloor(document, hall, longest_px);
  return {
    objects: [floor, steel, makeBoxes(hall, boxFace)],
    showFrom: (outside) => {
      steel.geometry.setDrawRange(0, outside ? openIndices : Infinity);
      setHaze(outside ? 0 : FOG_DENSITY);
    },
  };
}
