/** Curves and small shapes as paths of a canvas, in pixels. */

import { conicPoint } from "../geometry/conics.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {import("../view.js").View} View
 * @typedef {object} Look  of a mark
 * @property {"ring"|"disc"|"square"|"diamond"|"cross"} shape
 * @property {number} r
 * @property {string} colour
 * @property {string} back  inside of rings, squares and diamonds
 *
 * @typedef {CanvasRenderingContext2D|OffscreenCanvasRenderingContext2D|Path2D} Pen
 */

/**
 * Add a curve to the path.
 * @param {Pen} pen
 * @param {Curve} c
 * @param {View} view
 */
export function trace(pen, c, view) {
  const { scale: s, x, y } = view;
  if (c.type === "line") {
    pen.moveTo(x + s * c.x1, y - s * c.y1);
    pen.lineTo(x + s * c.x2, y - s * c.y2);
  } else if (c.type === "conic") traceConic(pen, c, view);
  else {
    const [first] = c.pieces;
    pen.moveTo(x + s * first[0], y - s * first[1]);
    for (const b of c.pieces) {
      pen.bezierCurveTo(x + s * b[2], y - s * b[3], x + s * b[4], y - s * b[5], x + s * b[6], y - s * b[7]);
    }
  }
}

/** @param {Pen} pen @param {import("../types.js").Conic} c @param {View} view */
function traceConic(pen, c, view) {
  const rx = Math.abs(c.rx) * view.scale;
  const ry = Math.abs(c.ry) * view.scale;
  const [mx, my] = view.toScreen([c.cx, c.cy]);
  const [sx, sy] = view.toScreen(conicPoint(c, c.start));
  pen.moveTo(sx, sy);
  if (Math.max(rx, ry) > 1e6) return traceFlat(pen, c, view);
  // angles run clockwise on the screen, where y points down
  pen.ellipse(mx, my, rx, ry, -c.turn, -c.start, -(c.start + c.sweep), c.sweep > 0);
}

/** Very large arcs: `ellipse` loses digits. @param {Pen} pen @param {import("../types.js").Conic} c @param {View} view */
function traceFlat(pen, c, view) {
  for (let i = 1; i <= 500; i++) {
    const [x, y] = view.toScreen(conicPoint(c, c.start + (c.sweep * i) / 500));
    pen.lineTo(x, y);
  }
}

/** @param {Pen} pen @param {Point[]} points @param {boolean} [close] */
export function polyline(pen, points, close = false) {
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  if (close) pen.closePath();
}

/** @param {Pen} pen @param {number} x @param {number} y @param {number} r */
export function disc(pen, x, y, r) {
  pen.moveTo(x + r, y);
  pen.arc(x, y, r, 0, 2 * Math.PI);
}

/**
 * Draws marks of points in one of five shapes. Each is drawn by itself, rings as a disc in a disc: the
 * rasteriser has a quick way for one circle or rectangle, and none for a path of many.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Look} look
 * @returns {(x: number, y: number) => void}
 */
export function markPen(ctx, { shape, r, colour, back }) {
  const line = shape === "cross" ? 2.2 : 1.5;
  const fill = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ radius, /** @type {string} */ with_) => {
    ctx.fillStyle = with_;
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    ctx.fill();
  };
  if (shape === "disc") return (x, y) => fill(x, y, r, colour);
  if (shape === "ring") {
    return (x, y) => {
      fill(x, y, r + line / 2, colour);
      fill(x, y, r - line / 2, back);
    };
  }
  const box = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ half, /** @type {string} */ with_) => {
    ctx.fillStyle = with_;
    ctx.fillRect(x - half, y - half, 2 * half, 2 * half);
  };
  if (shape === "square") {
    return (x, y) => {
      box(x, y, r + 1 + line / 2, colour);
      box(x, y, r + 1 - line / 2, back);
    };
  }
  return (x, y) => {
    ctx.fillStyle = back;
    ctx.strokeStyle = colour;
    ctx.lineWidth = line;
    ctx.beginPath();
    if (shape === "diamond") {
      const s = r + 2.2;
      polyline(ctx, [[x - s, y], [x, y - s], [x + s, y], [x, y + s]], true);
      ctx.fill();
    } else {
      const s = r + 1.8;
      polyline(ctx, [[x - s, y - s], [x + s, y + s]]);
      polyline(ctx, [[x - s, y + s], [x + s, y - s]]);
    }
    ctx.stroke();
  };
}
