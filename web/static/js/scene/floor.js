// The floor: polished concrete with painted lines, soft shade and a faint mirror of lights and racks.

import {
  CanvasTexture, DataTexture, LinearFilter, LinearMipmapLinearFilter, Mesh, PlaneGeometry,
  RepeatWrapping, ShaderMaterial, Color, Vector2, Vector3,
} from "three";
import { computeShade, drawPaint, makeConcrete } from "./floor_maps.js";
import { STATION_COLOURS } from "./palette.js";
import { CEILING_M, RACK_TOP_M } from "./space.js";
import { FOG_COLOUR, FOG_DENSITY, PANEL_HALF_M, PANEL_PITCH_M } from "./light.js";

/** @typedef {import("./space.js").HallPlan} HallPlan */

const VERTEX = `
varying vec3 vAt;
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  vAt = world.xyz;
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const FRAGMENT = `
uniform sampler2D paint, shade, concrete;
uniform vec2 hall, pitch, panel;
uniform vec3 station[4], fogColour;
uniform float ceiling, rackTop, fogDensity;
varying vec3 vAt;

float lights(vec2 at, float blur) {
  vec2 q = abs(mod(at - 0.5 * (hall - pitch * floor(hall / pitch)), pitch) - 0.5 * pitch) - panel;
  vec2 edge = smoothstep(vec2(blur), vec2(-blur), q);
  vec2 inside = step(vec2(0.0), at) * step(at, hall);
  return edge.x * edge.y * inside.x * inside.y;
}

vec3 mirrored(vec2 plan, vec3 ray, float rough) {
  float reach = rackTop / max(ray.y, 0.04);
  float hidden = 0.0;
  for (int n = 1; n <= 6; n++) {
    float t = float(n) / 6.0;
    vec2 at = plan + vec2(ray.x, -ray.z) * reach * t * t;
    float solid = texture2D(shade, at / hall).g;
    hidden = max(hidden, solid * (1.0 - 0.35 * t));
  }
  vec2 hit = plan + vec2(ray.x, -ray.z) * ceiling / max(ray.y, 0.04);
  float lamp = lights(hit, 0.4 + rough) * smoothstep(0.45, 0.12, ray.y);
  return mix(vec3(0.34, 0.36, 0.38) + vec3(1.5) * lamp, vec3(0.13, 0.14, 0.15), hidden);
}

void main() {
  vec2 plan = vec2(vAt.x, -vAt.z);
  vec4 stain = texture2D(concrete, plan / 5.0);
  vec4 fine = texture2D(concrete, plan / 1.1);
  float mottle = 0.6 * stain.r + 0.4 * texture2D(concrete, plan.yx / 13.0).r;
  vec3 albedo = vec3(0.245, 0.252, 0.26) * (0.62 + 0.7 * mottle) * (0.95 + 0.1 * fine.g);
  vec2 joint = abs(mod(plan, 6.0) - 3.0);
  vec2 seam = smoothstep(fwidth(plan) + 0.008, vec2(0.006), 3.0 - joint) * min(vec2(1.0), 0.02 / fwidth(plan));
  albedo *= 1.0 - 0.4 * max(seam.x, seam.y);

  vec3 mask = texture2D(paint, plan / hall).rgb;
  vec3 soft = clamp(fwidth(mask) * 0.7, 0.04, 0.5);
  vec3 cover = smoothstep(0.5 - soft, 0.5 + soft, mask) * (0.8 + 0.25 * smoothstep(0.25, 0.5, fine.r));
  int corner = plan.y < hall.y * 0.5 ? (plan.x < hall.x * 0.5 ? 0 : 1) : (plan.x < hall.x * 0.5 ? 3 : 2);
  albedo = mix(albedo, vec3(0.80, 0.50, 0.035), cover.r * 0.92);
  albedo = mix(albedo, vec3(0.78), cover.g * 0.9);
  albedo = mix(albedo, station[corner], cover.b * 0.95);

  vec3 toEye = cameraPosition - vAt;
  float far = length(toEye);
  vec3 view = toEye / far;
  float shadow = texture2D(shade, plan / hall).r;
  vec3 colour = albedo * shadow * 1.55;
  float graze = 0.03 + 0.5 * pow(1.0 - view.y, 4.0);
  vec3 ray = reflect(-view, normalize(vec3((stain.r - 0.5) * 0.02, 1.0, (fine.r - 0.5) * 0.02)));
  float gloss = 0.75 + 0.5 * mottle;
  colour = mix(colour, mirrored(plan, ray, 0.03 * far), graze * gloss * (0.45 + 0.55 * shadow));
  float haze = 1.0 - exp(-fogDensity * fogDensity * far * far);
  gl_FragColor = vec4(mix(colour, fogColour, haze), 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;

/** @param {Uint8Array} data @param {number} wide @param {number} tall @param {boolean} repeats */
function dataTexture(data, wide, tall, repeats) {
  const texture = new DataTexture(data, wide, tall);
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  if (repeats) texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

/** @param {Document} document @param {HallPlan} hall @param {number} longest_px allowed for a texture */
function makeMaterial(document, hall, longest_px) {
  const long = Math.max(hall.hall_width_m, hall.hall_height_m) > 32 ? 3072 : 2048;
  const paint = new CanvasTexture(drawPaint(document, hall, Math.min(longest_px, long)));
  paint.anisotropy = 8;
  const shade = computeShade(hall);
  return new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 6,
    uniforms: {
      paint: { value: paint },
      shade: { value: dataTexture(shade.data, shade.wide, shade.tall, false) },
      concrete: { value: dataTexture(makeConcrete(256), 256, 256, true) },
      hall: { value: new Vector2(hall.hall_width_m, hall.hall_height_m) },
      pitch: { value: new Vector2(...PANEL_PITCH_M) },
      panel: { value: new Vector2(...PANEL_HALF_M) },
      station: { value: STATION_COLOURS.map((hex) => new Vector3(...new Color(hex).toArray())) },
      fogColour: { value: new Color(FOG_COLOUR) },
      fogDensity: { value: FOG_DENSITY },
      ceiling: { value: CEILING_M },
      rackTop: { value: RACK_TOP_M },
    },
  });
}

/** @param {Document} document @param {HallPlan} hall @param {number} longest_px longest side of a texture @returns {{ floor: Mesh, setHaze: (density: number) => void }} */
export function makeFloor(document, hall, longest_px) {
  const plane = new PlaneGeometry(hall.hall_width_m, hall.hall_height_m);
  plane.rotateX(-Math.PI / 2);
  plane.translate(hall.hall_width_m / 2, 0, -hall.hall_height_m / 2);
  const material = makeMaterial(document, hall, longest_px);
  const { fogDensity } = material.uniforms;
  return { floor: new Mesh(plane, material), setHaze: (density) => (fogDensity.value = density) };
}
