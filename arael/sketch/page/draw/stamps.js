/**
 * Marks of points as small images: a mark is rasterised once for each quarter of a pixel that it may
 * stand at, and laid on a drawing by hand from then on.
 */

import { markPen } from "./paths.js";
import { dotsOf } from "./sheet.js";

/** Places between two pixels, in each direction. */
const STEPS = 4;
/** Looks that are kept; each theme, state and pixel ratio has its own. */
const MOST = 60;

/** Images by look. @type {Map<string, Int32Array[]>} */
const stamps = new Map();

/**
 * Lay marks of one look.
 * @param {import("./sheet.js").Sheet} sheet
 * @param {import("./paths.js").Look} look
 * @param {Float64Array} places  x, y, x, y, twice the same
 * @param {number} count
 */
export function stampMarks(sheet, look, places, count) {
  const { ratio } = sheet;
  // the tips of a diamond reach farthest
  const half = Math.ceil((look.r + 4) * ratio) + 1;
  const key = JSON.stringify([look, ratio]);
  if (stamps.size >= MOST) stamps.clear();
  // full from the beginning: for arrays with holes the browser compiles its loops anew
  const images = stamps.get(key) ?? Array(STEPS * STEPS).fill(null);
  stamps.set(key, images);
  for (let i = 0; i < 4 * count; i += 4) {
    const x = Math.round(STEPS * ratio * places[i]);
    const y = Math.round(STEPS * ratio * places[i + 1]);
    const left = Math.floor(x / STEPS);
    const top = Math.floor(y / STEPS);
    const which = STEPS * (y - STEPS * top) + x - STEPS * left;
    images[which] ??= dotsOf(2 * half, (ctx) => {
      ctx.setTransform(ratio, 0, 0, ratio, half + x / STEPS - left, half + y / STEPS - top);
      markPen(ctx, look)(0, 0);
    });
    sheet.stamp(images[which], left - half, top - half);
  }
}
