/** Colours from CSS variables, and the shapes that tell states apart without colour. */

const NAMES = /** @type {const} */ ([
  "background", "grid", "grid-strong", "axis-x", "axis-y", "free", "defined", "redundant", "impossible",
  "selected", "construction", "halo-redundant", "halo-impossible", "halo-selected", "halo-hovered",
  "dimension", "derived", "glyph", "glyph-back", "glyph-edge", "note", "preview", "guide", "snap",
  "label", "label-back",
]);

/** @typedef {Record<typeof NAMES[number], string>} Palette */

/** Dashes of line styles. @type {Record<string, number[]>} */
export const STYLE_DASHES = { solid: [], dashed: [9, 5], dashdot: [12, 4, 1.5, 4] };
export const CONSTRUCTION_DASH = [4, 4];
/** Dashes of badges and dimensions by their state. @type {Record<string, number[]>} */
export const EDGES = { redundant: [2, 2.5], impossible: [5, 2.5] };
export const FONT = "'Inter', 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";

/**
 * How a state looks besides its colour.
 * @type {Record<string, {width: number, halo: number, dash: number[], end: "ring"|"disc"|"square"|"diamond"|"cross"}>}
 */
export const STATES = {
  free: { width: 1.7, halo: 0, dash: [], end: "ring" },
  defined: { width: 2.1, halo: 0, dash: [], end: "disc" },
  redundant: { width: 2.1, halo: 8, dash: [2, 5], end: "diamond" },
  impossible: { width: 2.1, halo: 8, dash: [9, 4], end: "cross" },
  selected: { width: 2.1, halo: 9, dash: [], end: "square" },
};

/**
 * The colours that hold now.
 * @param {Element} element
 * @returns {Palette}
 */
export function readPalette(element) {
  // a variable is read as it is written, with both themes; as the colour of an element it is the one that holds
  const probe = element.ownerDocument.createElement("i");
  probe.hidden = true;
  element.append(probe);
  const style = getComputedStyle(probe);
  const found = /** @type {Palette} */ ({});
  for (const name of NAMES) {
    probe.style.color = `var(--sketch-${name}, #888)`;
    found[name] = style.color;
  }
  probe.remove();
  return found;
}
