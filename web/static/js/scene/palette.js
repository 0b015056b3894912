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

/**
 * Black or white, whichever is easier to read on the given colour (WCAG relative luminance).
 * @param {string} hex @returns {"#10151c" | "#ffffff"}
 */
export function inkOn(hex) {
  const channel = (/** @type {number} */ at) => {
    const value = parseInt(hex.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  };
  const luminance = 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
  return luminance > 0.3 ? "#10151c" : "#ffffff";
}
