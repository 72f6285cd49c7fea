/**
 * Dimensions drawn by hand, as `sheet.js` says: lines and arrows as pixels, texts as small images that are
 * rasterised once and stand at whole pixels.
 */

import { SLOPE, writer } from "./dimension_marks.js";
import { dotsOf } from "./sheet.js";

/** @typedef {import("./lines.js").Drawn} Drawn */

/** Images that are kept; each theme, state and pixel ratio has its own. */
const MOST = 300;

/** Images of texts. @type {Map<string, Int32Array>} */
const texts = new Map();

/**
 * Draw dimensions of one colour: those without arcs, with solid lines.
 * @param {import("./sheet.js").Sheet} sheet @param {Drawn[]} all @param {string} colour @param {string} back
 */
export function layDimensions(sheet, all, colour, back) {
  const { ratio } = sheet;
  const ink = sheet.colour(colour);
  for (const { lines, thin, arrows } of all) {
    // as the canvas draws them, with three fifths of the ink
    sheet.lines(thin, thin.length / 4, 0.8, (ink & 0xffffff) | (153 << 24));
    sheet.lines(lines, lines.length / 4, 1, ink);
    sheet.arrows(arrows, SLOPE, ink);
  }
  for (const { half, text: { x, y, angle, text } } of all) {
    const reach = Math.ceil((half + 8) * ratio);
    const key = `${text} ${angle} ${colour} ${back} ${ratio}`;
    let image = texts.get(key);
    if (!image) {
      if (texts.size >= MOST) texts.clear();
      image = dotsOf(2 * reach, (ctx) => {
        ctx.setTransform(ratio, 0, 0, ratio, reach, reach);
        writer(ctx, colour, back)(text, 0, 0, angle);
      });
      texts.set(key, image);
    }
    sheet.stamp(image, Math.round(ratio * Math.round(x)) - reach, Math.round(ratio * Math.round(y)) - reach);
  }
}
