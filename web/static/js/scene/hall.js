// Everything in the hall that never moves, as three draw calls: floor, steel and walls, boxes.

import { Mesh, MeshLambertMaterial } from "three";
import { MeshBuilder } from "./builder.js";
import { makeFloor } from "./floor.js";
import { addRacks, Boxes } from "./racks.js";
import { addShell } from "./shell.js";
import { addStations } from "./stations.js";

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

/**
 * @param {Document} document @param {HallPlan} hall @param {number} robots
 * @param {import("three").Texture} atlas @param {number} longestTexture_px
 * @returns {{ meshes: import("three").Object3D[], boxes: Boxes }}
 */
export function makeHall(document, hall, robots, atlas, longestTexture_px) {
  const builder = new MeshBuilder();
  addShell(builder, hall);
  addStations(builder, hall);
  addRacks(builder, hall);
  const steel = new Mesh(builder.build(), makeMaterial(atlas));
  const boxes = new Boxes(document, hall, robots);
  return { meshes: [makeFloor(document, hall, longestTexture_px), steel, boxes.mesh], boxes };
}
