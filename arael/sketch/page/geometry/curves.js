/** Curves by kind: points, directions, nearest points, bounds. */

import { arcOf, conicBounds, conicNearest, conicPoint, conicTangent } from "./conics.js";
import { pieceBounds, piecePoint, pieceTangent, pieceNearest, splinePieces } from "./splines.js";
import { dist, dot, mix, sub, unit } from "./vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {import("../types.js").Line} Line
 * @typedef {import("../types.js").Conic} Conic
 * @typedef {import("../types.js").Entity} Entity
 * @typedef {import("../view.js").Box} Box
 * @typedef {{at: Point, t: number, distance: number}} Foot
 */

/**
 * Curve of an entity; null for a point.
 * @param {Entity} entity
 * @param {Float64Array} values
 * @returns {Curve|null}
 */
export function curveOf(entity, values) {
  const { at, kind } = entity;
  switch (kind) {
    case "point":
      return null;
    case "line":
      return { type: "line", x1: values[at], y1: values[at + 1], x2: values[at + 2], y2: values[at + 3] };
    case "circle":
    case "arc":
    case "ellipse":
    case "earc":
      return arcOf(kind, values, at);
    default:
      return spline(polesOf(values, at, entity.size));
  }
}

/** @param {Float64Array} values @param {number} at @param {number} size @returns {Point[]} */
function polesOf(values, at, size) {
  /** @type {Point[]} */
  const poles = [];
  for (let i = at; i < at + size; i += 2) poles.push([values[i], values[i + 1]]);
  return poles;
}

/** @param {Point} a @param {Point} b @returns {Line} */
export const line = (a, b) => ({ type: "line", x1: a[0], y1: a[1], x2: b[0], y2: b[1] });

/** @param {Point} c @param {number} r @returns {Conic} */
export function circle(c, r) {
  return { type: "conic", cx: c[0], cy: c[1], rx: r, ry: r, turn: 0, start: 0, sweep: 2 * Math.PI, closed: true };
}

/** Clamped cubic spline of four poles or more. @param {Point[]} poles @returns {import("../types.js").Spline} */
export const spline = (poles) => ({ type: "spline", poles, pieces: splinePieces(poles) });

/** Ends of a line. @param {Line} c @returns {[Point, Point]} */
export const lineEnds = (c) => [[c.x1, c.y1], [c.x2, c.y2]];

/** Point at a fraction of the parameter. @param {Curve} c @param {number} t @returns {Point} */
export function pointAt(c, t) {
  if (c.type === "line") return [c.x1 + t * (c.x2 - c.x1), c.y1 + t * (c.y2 - c.y1)];
  if (c.type === "conic") return conicPoint(c, c.start + t * c.sweep);
  const [i, u] = pieceAt(c.pieces.length, t);
  return piecePoint(c.pieces[i], u);
}

/** Unit direction of travel. @param {Curve} c @param {number} t @returns {Point} */
export function tangentAt(c, t) {
  if (c.type === "line") return unit([c.x2 - c.x1, c.y2 - c.y1]);
  if (c.type === "conic") return conicTangent(c, c.start + t * c.sweep);
  const [i, u] = pieceAt(c.pieces.length, t);
  return pieceTangent(c.pieces[i], u);
}

/** @param {number} count @param {number} t @returns {[number, number]} */
function pieceAt(count, t) {
  const i = Math.min(Math.max(Math.floor(t * count), 0), count - 1);
  return [i, t * count - i];
}

/** Nearest point of a curve. @param {Curve} c @param {Point} p @returns {Foot} */
export function nearest(c, p) {
  if (c.type === "line") {
    const [a, b] = lineEnds(c);
    const d = sub(b, a);
    const square = dot(d, d);
    const t = square > 0 ? Math.min(Math.max(dot(sub(p, a), d) / square, 0), 1) : 0;
    const at = mix(a, b, t);
    return { at, t, distance: dist(at, p) };
  }
  if (c.type === "conic") return conicNearest(c, p);
  /** @type {Foot|null} */
  let best = null;
  c.pieces.forEach((piece, i) => {
    const { t, at } = pieceNearest(piece, p);
    const distance = dist(at, p);
    if (!best || distance < best.distance) best = { at, t: (i + t) / c.pieces.length, distance };
  });
  return best ?? { at: c.poles[0], t: 0, distance: dist(c.poles[0], p) };
}

/** Rectangle around a curve. @param {Curve} c @returns {Box} */
export function boundsOf(c) {
  if (c.type === "line") {
    return {
      xmin: Math.min(c.x1, c.x2), ymin: Math.min(c.y1, c.y2),
      xmax: Math.max(c.x1, c.x2), ymax: Math.max(c.y1, c.y2),
    };
  }
  if (c.type === "conic") return conicBounds(c);
  return c.pieces.map(pieceBounds).reduce((a, b) => ({
    xmin: Math.min(a.xmin, b.xmin), ymin: Math.min(a.ymin, b.ymin),
    xmax: Math.max(a.xmax, b.xmax), ymax: Math.max(a.ymax, b.ymax),
  }));
}

/** Whether a curve has no ends. @param {Curve} c */
export const isClosed = (c) => c.type === "conic" && c.closed;

/**
 * Points along a curve, at most `step` apart, ends included.
 * @param {Curve} c
 * @param {number} step
 * @returns {Point[]}
 */
export function sample(c, step) {
  const length = roughLength(c);
  const least = c.type === "line" ? 1 : c.type === "conic" ? 8 : 8 * c.pieces.length;
  const count = Math.min(Math.max(Math.ceil(length / step), least), 2000);
  return Array.from({ length: count + 1 }, (_, i) => pointAt(c, i / count));
}

/** Length, roughly. @param {Curve} c */
export function roughLength(c) {
  if (c.type === "line") return Math.hypot(c.x2 - c.x1, c.y2 - c.y1);
  if (c.type === "conic") return 0.5 * (c.rx + c.ry) * Math.abs(c.sweep);
  return c.poles.slice(1).reduce((sum, p, i) => sum + dist(p, c.poles[i]), 0);
}
