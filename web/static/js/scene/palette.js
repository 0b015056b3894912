// Every colour that carries meaning in the hall. The sixteen robot colours were spread by
// maximising their smallest CIELAB distance under normal, protan, deutan and tritan vision;
// each robot also carries its number, so colour is never the only sign.

/** Colour of robot k, as CSS hex. */
export const ROBOT_COLOURS = Object.freeze([
  "#0298fe", "#d03f0a", "#ffe300", "#137a4b", "#f15eb7", "#0033ff", "#abff7a", "#6e10b0",
  "#e39c06", "#2cdca7", "#900061", "#b2bfff", "#94a253", "#632d00", "#ffffff", "#060060",
]);

/** Paint and signs of the four drop stations: bottom left, bottom right, top right, top left. */
export const STATION_COLOURS = Object.freeze(["#0f9aa0", "#7c5ac7", "#d98028", "#c8487f"]);

/** Box colours by index: red, green, blue, yellow. */
export const BOX_COLOURS = Object.freeze(["#c4594c", "#5f9e6d", "#5b80b8", "#dcb756"]);

export const BALLOON_COLOUR = "#e3202b";

/** @param {number} robot index from 0 @returns {string} CSS hex */
export function robotColour(robot) {
  return /** @type {string} */ (ROBOT_COLOURS[robot % ROBOT_COLOURS.length]);
}

/** WCAG relative luminance. @param {string} hex @returns {number} 0 to 1 */
function luminanceOf(hex) {
  const channel = (/** @type {number} */ at) => {
    const value = parseInt(hex.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  };
  return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
}

/** Black or white for the large numbers in the hall. @param {string} hex @returns {"#10151c" | "#ffffff"} */
export const inkOn = (hex) => (luminanceOf(hex) > 0.3 ? "#10151c" : "#ffffff");

/** Black or white for small type, whichever has the higher contrast. @param {string} hex @returns {"#000000" | "#ffffff"} */
export function smallInkOn(hex) {
  const paper = luminanceOf(hex) + 0.05;
  return paper / 0.05 > 1.05 / paper ? "#000000" : "#ffffff";
}
