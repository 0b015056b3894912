// The canvas and its renderer: size, pixel ratio, a lost and restored context, and a picture that
// becomes coarser by itself where the machine is slow.

import { NeutralToneMapping, PerspectiveCamera, Scene, WebGLRenderer, FogExp2, Color, Vector3 } from "three";
import { FOG_COLOUR, FOG_DENSITY, OUTSIDE_COLOUR } from "./light.js";
import { cameraTurn, FIELD_OF_VIEW_DEG } from "./space.js";

/** @typedef {"auto" | "on" | "off"} Antialias */

/** Nearest and farthest that the participant's view draws. */
const NEAR_M = 0.1;
const FAR_M = 140;
const RATIO_MAX = 2;
const RATIO_LEAST = 0.6;
/** A frame slower than this counts as slow; so many slow ones in a row make the picture coarser. */
const SLOW_MS = 27;
const SLOW_FRAMES = 40;
const QUICK_MS = 13;
const QUICK_FRAMES = 300;

/** Thrown where the browser offers no WebGL. */
export class NoWebGlError extends Error {}

/** Whether WebGL is drawn by the processor, not by a graphics card. @param {WebGLRenderingContext | WebGL2RenderingContext} gl */
export function isSoftwareDrawn(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** @param {Document} document @returns {boolean} whether a context could be had, drawn in software */
function probeSoftware(document) {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) throw new NoWebGlError("This browser offers no WebGL 2.");
  const software = isSoftwareDrawn(gl);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return software;
}

/** Renderer, scene and camera. */
export class Stage {
  /** @param {HTMLElement} parent @param {Antialias} antialias @param {(lost: boolean) => void} contextChanged */
  constructor(parent, antialias, contextChanged) {
    this.parent = parent;
    const window = /** @type {Window} */ (parent.ownerDocument.defaultView);
    this.window = window;
    const software = antialias === "auto" && probeSoftware(parent.ownerDocument);
    try {
      this.renderer = new WebGLRenderer({ antialias: antialias !== "off" && !software, powerPreference: "high-performance" });
    } catch (error) {
      throw new NoWebGlError(error instanceof Error ? error.message : String(error));
    }
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.toneMappingExposure = 1;
    this.canvas = this.renderer.domElement;
    this.canvas.className = "view";
    this.canvas.tabIndex = -1;
    parent.prepend(this.canvas);
    this.scene = new Scene();
    this.scene.background = new Color(FOG_COLOUR);
    this.scene.fog = new FogExp2(FOG_COLOUR, FOG_DENSITY);
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, NEAR_M, FAR_M);
    this.camera.rotation.order = "YXZ";
    this.ratio = Math.min(RATIO_MAX, window.devicePixelRatio || 1);
    this.ratioCap = this.ratio;
    this.lost = false;
    this.slow = 0;
    this.quick = 0;
    this.size = { width: 0, height: 0 };
    this.#watchContext(contextChanged);
    this.resize();
    window.addEventListener("resize", () => this.resize());
  }

  /** @param {(lost: boolean) => void} contextChanged */
  #watchContext(contextChanged) {
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.lost = true;
      contextChanged(true);
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      contextChanged(false);
    });
  }

  /** The longest side a texture may have. */
  get longestTexture_px() {
    return this.renderer.capabilities.maxTextureSize;
  }

  resize() {
    const width = Math.max(1, this.parent.clientWidth);
    const height = Math.max(1, this.parent.clientHeight);
    const deviceRatio = Math.min(RATIO_MAX, this.window.devicePixelRatio || 1);
    if (deviceRatio !== this.ratioCap) this.ratio = this.ratioCap = deviceRatio;
    this.size = { width, height };
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Half of the horizontal field of view in radians. */
  get halfView() {
    return Math.atan(Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.aspect);
  }

  /**
   * Points the camera. @param {import("./space.js").Sighting} at plan metres and radians
   * @param {boolean} outside looks in without ceiling: no haze
   */
  aim(at, outside) {
    const { camera } = this;
    const fog = /** @type {FogExp2} */ (this.scene.fog);
    fog.density = outside ? 0 : FOG_DENSITY;
    /** @type {Color} */ (this.scene.background).set(outside ? OUTSIDE_COLOUR : FOG_COLOUR);
    const [fov, near, far] = [at.fov_deg ?? FIELD_OF_VIEW_DEG, at.near_m ?? NEAR_M, at.far_m ?? FAR_M];
    if (camera.fov !== fov || camera.near !== near || camera.far !== far) {
      Object.assign(camera, { fov, near, far });
      camera.updateProjectionMatrix();
    }
    camera.position.set(at.x, at.height_m, -at.y);
    camera.rotation.set(at.pitch, cameraTurn(at.heading), 0);
    camera.updateMatrixWorld();
  }

  /** Where a place is in the picture. @param {number} x @param {number} y @param {number} height_m @returns {{ x: number, y: number } | null} pixels, y down; null behind the camera */
  project(x, y, height_m) {
    const { camera, size } = this;
    const point = new Vector3(x, height_m, -y).applyMatrix4(camera.matrixWorldInverse);
    if (-point.z < camera.near) return null;
    point.applyMatrix4(camera.projectionMatrix);
    return { x: (point.x * 0.5 + 0.5) * size.width, y: (0.5 - point.y * 0.5) * size.height };
  }

  /** Watches how long frames take and adapts the pixel ratio. @param {number} frame_ms time since the last frame */
  adapt(frame_ms) {
    if (frame_ms > 500) return;
    this.slow = frame_ms > SLOW_MS ? this.slow + 1 : 0;
    this.quick = frame_ms < QUICK_MS ? this.quick + 1 : 0;
    if (this.slow > SLOW_FRAMES && this.ratio > RATIO_LEAST) this.#setRatio(Math.max(RATIO_LEAST, this.ratio * 0.8));
    else if (this.quick > QUICK_FRAMES && this.ratio < this.ratioCap) this.#setRatio(Math.min(this.ratioCap, this.ratio * 1.15));
  }

  /** @param {number} ratio */
  #setRatio(ratio) {
    this.ratio = ratio;
    this.slow = this.quick = 0;
    this.renderer.setPixelRatio(ratio);
  }

  draw() {
    if (!this.lost) this.renderer.render(this.scene, this.camera);
  }
}
