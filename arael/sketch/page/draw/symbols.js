/** One symbol for every kind of constraint, drawn in a box from -1 to 1 (y down). */

import { disc, polyline } from "./paths.js";

/** @typedef {import("./paths.js").Pen} Pen */

/** @param {Pen} p */
const lock = (p) => {
  polyline(p, [[-0.62, -0.1], [0.62, -0.1], [0.62, 0.8], [-0.62, 0.8]], true);
  p.moveTo(-0.38, -0.1);
  p.bezierCurveTo(-0.4, -0.95, 0.4, -0.95, 0.38, -0.1);
};

/** @type {Record<string, (p: Pen) => void>} */
export const SYMBOLS = {
  horizontal: (p) => polyline(p, [[-0.8, 0], [0.8, 0]]),
  vertical: (p) => polyline(p, [[0, -0.8], [0, 0.8]]),
  parallel: (p) => {
    polyline(p, [[-0.65, 0.7], [-0.05, -0.7]]);
    polyline(p, [[0.05, 0.7], [0.65, -0.7]]);
  },
  perpendicular: (p) => {
    polyline(p, [[0, -0.75], [0, 0.6]]);
    polyline(p, [[-0.75, 0.6], [0.75, 0.6]]);
  },
  collinear: (p) => {
    polyline(p, [[-0.9, 0.2], [-0.2, 0.2]]);
    polyline(p, [[0.2, 0.2], [0.9, 0.2]]);
    polyline(p, [[-0.55, -0.35], [0.55, -0.35]]);
  },
  equal: (p) => {
    polyline(p, [[-0.65, -0.3], [0.65, -0.3]]);
    polyline(p, [[-0.65, 0.3], [0.65, 0.3]]);
  },
  equal_angle: (p) => {
    polyline(p, [[0.75, 0.6], [-0.7, 0.6], [0.45, -0.65]]);
    p.moveTo(0.2, 0.6);
    p.bezierCurveTo(0.2, 0.2, 0.05, -0.05, -0.1, -0.1);
  },
  tangent: (p) => {
    disc(p, 0, 0.2, 0.5);
    polyline(p, [[-0.85, -0.36], [0.85, -0.36]]);
  },
  smooth: (p) => {
    p.moveTo(-0.85, 0.45);
    p.bezierCurveTo(-0.2, 0.9, -0.25, -0.55, 0.05, -0.2);
    p.bezierCurveTo(0.3, 0.1, 0.4, -0.7, 0.85, -0.45);
  },
  coincident: (p) => {
    disc(p, 0, 0, 0.22);
    disc(p, 0, 0, 0.65);
  },
  concentric: (p) => {
    disc(p, 0, 0, 0.75);
    disc(p, 0, 0, 0.32);
  },
  point_on: (p) => {
    polyline(p, [[-0.85, 0.55], [0.85, -0.55]]);
    disc(p, 0, 0, 0.3);
  },
  midpoint: (p) => polyline(p, [[-0.7, 0.5], [0, -0.6], [0.7, 0.5]], true),
  symmetry: (p) => {
    polyline(p, [[0, -0.8], [0, 0.8]]);
    polyline(p, [[-0.75, -0.4], [-0.3, 0], [-0.75, 0.4]]);
    polyline(p, [[0.75, -0.4], [0.3, 0], [0.75, 0.4]]);
  },
  on_normal: (p) => {
    polyline(p, [[-0.8, 0.6], [0.8, 0.6]]);
    polyline(p, [[0, 0.6], [0, -0.4]]);
    disc(p, 0, -0.55, 0.2);
  },
  image: (p) => {
    polyline(p, [[-0.75, -0.75], [0.15, -0.75], [0.15, 0.15], [-0.75, 0.15]], true);
    polyline(p, [[0.4, -0.2], [0.75, -0.2], [0.75, 0.75], [-0.2, 0.75], [-0.2, 0.4]]);
  },
  lock,
  fix: (p) => {
    lock(p);
    disc(p, 0, 0.35, 0.1);
  },
};

/**
 * A badge with a constraint's symbol.
 * @param {CanvasRenderingContext2D} ctx
 * @param {string} kind
 * @param {number} x
 * @param {number} y
 * @param {{half: number, back: string, edge: string, ink: string, width?: number, dash?: number[]}} look
 */
export function drawBadge(ctx, kind, x, y, look) {
  const { half } = look;
  ctx.beginPath();
  ctx.roundRect(x - half, y - half, 2 * half, 2 * half, 3);
  ctx.fillStyle = look.back;
  ctx.fill();
  ctx.strokeStyle = look.edge;
  ctx.lineWidth = look.width ?? 0.9;
  ctx.setLineDash(look.dash ?? []);
  ctx.stroke();
  ctx.setLineDash([]);
  const draw = SYMBOLS[kind];
  if (!draw) return;
  const size = 0.72 * half;
  ctx.save();
  ctx.translate(x, y);
  ctx.scale(size, size);
  ctx.beginPath();
  draw(ctx);
  ctx.restore();
  ctx.strokeStyle = look.ink;
  ctx.lineWidth = 1.3;
  ctx.stroke();
}
