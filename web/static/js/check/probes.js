// Measurements of the browser: WebGL, frame rate, the way to the server and back.

const FRAMES = 60;
const LONGEST_MS = 4000;

/** Whether WebGL 2 can be had. @param {Document} document */
export function probeWebGl(document) {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return true;
}

/**
 * Pictures per second while a canvas is cleared by the graphics card in every one.
 * @param {Window} window @returns {Promise<number>}
 */
export function measureFrameRate(window) {
  const canvas = window.document.createElement("canvas");
  canvas.width = 640;
  canvas.height = 360;
  const gl = canvas.getContext("webgl2");
  return new Promise((resolve) => {
    let frames = 0;
    let first_ms = 0;
    const draw = (/** @type {number} */ now_ms) => {
      if (frames === 0) first_ms = now_ms;
      const passed_ms = now_ms - first_ms;
      if (frames >= FRAMES || (frames > 1 && passed_ms > LONGEST_MS)) {
        gl?.getExtension("WEBGL_lose_context")?.loseContext();
        resolve(passed_ms > 0 ? (frames * 1000) / passed_ms : 0);
        return;
      }
      frames += 1;
      gl?.clearColor(0, frames / FRAMES, 0, 1);
      gl?.clear(gl.COLOR_BUFFER_BIT);
      window.requestAnimationFrame(draw);
    };
    window.requestAnimationFrame(draw);
  });
}

/**
 * Median time of several small requests, one after the other.
 * @param {string} address @param {number} times @returns {Promise<number | null>} milliseconds; null if none was answered
 */
export async function measureLatency(address, times) {
  /** @type {number[]} */
  const spans = [];
  for (let n = 0; n < times; n += 1) {
    const start_ms = performance.now();
    try {
      const response = await fetch(address, { cache: "no-store" });
      await response.text();
      if (response.ok) spans.push(performance.now() - start_ms);
    } catch {
      return null;
    }
  }
  spans.sort((a, b) => a - b);
  return spans[spans.length >> 1] ?? null;
}
