/** Texts on the canvas. */

import { boxOfText, traceText } from "../geometry/lettering.js";

/** Lower texts, in pixels, are drawn as a line. */
const LEGIBLE = 3;

/**
 * Add the lettering of a frame to the path.
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("../view.js").View} view
 * @param {import("../types.js").Entity} frame
 * @param {Float64Array} v
 */
export function traceLettering(ctx, view, { text, at }, v) {
  if (!text) return;
  const [a, b] = [view.toScreen([v[at], v[at + 1]]), view.toScreen([v[at + 2], v[at + 3]])];
  if (a[0] === b[0] && a[1] === b[1]) return;
  // on the screen y points down: the box is that of the frame in the opposite direction
  const box = boxOfText(text, b, a);
  const [xs, ys] = [box.map((p) => p[0]), box.map((p) => p[1])];
  if (Math.max(...xs) < 0 || Math.min(...xs) > view.width || Math.max(...ys) < 0 || Math.min(...ys) > view.height) return;
  const [p, , , q] = box;
  if (Math.hypot(q[0] - p[0], q[1] - p[1]) < LEGIBLE) {
    ctx.moveTo((p[0] + q[0]) / 2, (p[1] + q[1]) / 2);
    ctx.lineTo((box[1][0] + box[2][0]) / 2, (box[1][1] + box[2][1]) / 2);
  } else traceText(ctx, text, a, b);
}
