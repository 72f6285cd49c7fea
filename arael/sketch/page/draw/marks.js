/** Marks of the ten kinds of snap, each of its own shape. */

import { disc, polyline } from "./paths.js";

/** @typedef {import("./paths.js").Pen} Pen */

const R = 6;

/** @type {Record<import("../types.js").SnapKind, (p: Pen, x: number, y: number) => void>} */
export const SNAP_MARKS = {
  endpoint: (p, x, y) => p.rect(x - R, y - R, 2 * R, 2 * R),
  centre: (p, x, y) => disc(p, x, y, R),
  midpoint: (p, x, y) => polyline(p, [[x - R, y + R - 1], [x, y - R], [x + R, y + R - 1]], true),
  quadrant: (p, x, y) => polyline(p, [[x - R - 1, y], [x, y - R - 1], [x + R + 1, y], [x, y + R + 1]], true),
  intersection: (p, x, y) => {
    polyline(p, [[x - R, y - R], [x + R, y + R]]);
    polyline(p, [[x - R, y + R], [x + R, y - R]]);
  },
  nearest: (p, x, y) => polyline(p, [[x - R, y - R], [x + R, y - R], [x - R, y + R], [x + R, y + R]], true),
  tangent: (p, x, y) => {
    disc(p, x, y + 2, R - 2);
    polyline(p, [[x - R - 1, y - R + 3], [x + R + 1, y - R + 3]]);
  },
  perpendicular: (p, x, y) => {
    polyline(p, [[x - R, y - R], [x - R, y + R], [x + R, y + R]]);
    polyline(p, [[x - R, y], [x, y], [x, y + R]]);
  },
  alignment: (p, x, y) => {
    polyline(p, [[x - R, y], [x + R, y]]);
    polyline(p, [[x, y - R], [x, y + R]]);
    disc(p, x, y, 2);
  },
  grid: (p, x, y) => {
    polyline(p, [[x - 4, y], [x + 4, y]]);
    polyline(p, [[x, y - 4], [x, y + 4]]);
  },
};

/**
 * A bar across a curve, with serifs like a bracket on each side of the cut.
 * @param {Pen} p
 * @param {number} x
 * @param {number} y
 * @param {import("../types.js").Point} along  direction of the curve in the sketch
 */
export function cutMark(p, x, y, along) {
  const size = Math.hypot(...along) || 1;
  const [u, v] = [along[0] / size, -along[1] / size];
  const half = R + 3;
  polyline(p, [[x - half * v, y + half * u], [x + half * v, y - half * u]]);
  for (const side of [1, -1]) {
    const [ex, ey] = [x + side * half * v, y - side * half * u];
    polyline(p, [[ex - 3 * u, ey - 3 * v], [ex + 3 * u, ey + 3 * v]]);
  }
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("../types.js").SnapKind} kind
 * @param {number} x
 * @param {number} y
 * @param {import("./palette.js").Palette} palette
 */
export function drawSnapMark(ctx, kind, x, y, palette) {
  ctx.beginPath();
  SNAP_MARKS[kind](ctx, x, y);
  ctx.lineWidth = 4;
  ctx.strokeStyle = palette.background;
  ctx.stroke();
  ctx.lineWidth = 1.8;
  ctx.strokeStyle = palette.snap;
  ctx.stroke();
}
