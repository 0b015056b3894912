// Flat pictures from the atlas at places on the screen: labels, arrows. One draw call for all.

import { InstancedBufferAttribute, InstancedBufferGeometry, BufferAttribute, DynamicDrawUsage, Mesh, ShaderMaterial, Vector2 } from "three";

/** @typedef {import("./atlas.js").CellRect} CellRect */

const SPRITES_MAX = 128;

const VERTEX = `
attribute vec4 spot, rect;
attribute vec2 look;
uniform vec2 viewport;
varying vec2 vUv;
varying float vAlpha;
void main() {
  vUv = mix(rect.xy, rect.zw, position.xy + 0.5);
  vAlpha = look.y;
  vec2 corner = position.xy * spot.zw;
  float c = cos(look.x), s = sin(look.x);
  corner = vec2(c * corner.x + s * corner.y, -s * corner.x + c * corner.y);
  vec2 px = vec2(spot.x, viewport.y - spot.y) + corner;
  gl_Position = vec4(px / viewport * 2.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENT = `
uniform sampler2D atlas;
varying vec2 vUv;
varying float vAlpha;
void main() {
  vec4 texel = texture2D(atlas, vUv);
  gl_FragColor = vec4(texel.rgb, texel.a * vAlpha);
  #include <colorspace_fragment>
}`;

/** Screen pictures, collected anew every frame; later ones lie on top. */
export class Sprites {
  /** @param {import("three").Texture} atlas */
  constructor(atlas) {
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([-0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0]), 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const make = (/** @type {number} */ size) =>
      new InstancedBufferAttribute(new Float32Array(SPRITES_MAX * size), size).setUsage(DynamicDrawUsage);
    this.spot = make(4);
    this.rect = make(4);
    this.look = make(2);
    geometry.setAttribute("spot", this.spot);
    geometry.setAttribute("rect", this.rect);
    geometry.setAttribute("look", this.look);
    this.geometry = geometry;
    this.viewport = new Vector2(1, 1);
    const material = new ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthTest: false, depthWrite: false,
      uniforms: { atlas: { value: atlas }, viewport: { value: this.viewport } },
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 9;
    this.count = 0;
  }

  /** @param {number} width_px @param {number} height_px CSS pixels */
  begin(width_px, height_px) {
    this.count = 0;
    this.viewport.set(width_px, height_px);
  }

  /**
   * @param {CellRect} rect @param {number} x @param {number} y CSS pixels, y down
   * @param {number} w @param {number} h CSS pixels @param {{ turn?: number, alpha?: number }} look turn clockwise
   */
  add(rect, x, y, w, h, look) {
    if (this.count >= SPRITES_MAX) return;
    this.spot.setXYZW(this.count, x, y, w, h);
    this.rect.setXYZW(this.count, rect.u0, rect.v0, rect.u1, rect.v1);
    this.look.setXY(this.count, look.turn ?? 0, look.alpha ?? 1);
    this.count += 1;
  }

  end() {
    this.geometry.instanceCount = this.count;
    this.mesh.visible = this.count > 0;
    for (const attribute of [this.spot, this.rect, this.look]) attribute.needsUpdate = true;
  }
}
