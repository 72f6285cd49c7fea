/** Cubic Bezier pieces (eight numbers), and clamped cubic B-splines with uniform knots as pieces. */

import { unit } from "./vectors.js";

/** @typedef {import("../types.js").Point} Point */

/**
 * Pieces of a clamped cubic B-spline: knots inserted until each is threefold (Boehm 1980).
 * @param {Point[]} poles  at least four; four are one Bezier curve
 * @returns {number[][]}
 */
export function splinePieces(poles) {
  const spans = poles.length - 3;
  /** @type {number[]} */
  let knots = [0, 0, 0, 0];
  for (let i = 1; i < spans; i++) knots.push(i);
  knots.push(spans, spans, spans, spans);
  let points = poles.map((p) => /** @type {Point} */ ([p[0], p[1]]));
  for (let i = 1; i < spans; i++) {
    for (let times = 0; times < 2; times++) [knots, points] = inserted(knots, points, i);
  }
  return Array.from({ length: spans }, (_, i) => points.slice(3 * i, 3 * i + 4).flat());
}

/** @param {number[]} knots @param {Point[]} points @param {number} u @returns {[number[], Point[]]} */
function inserted(knots, points, u) {
  const k = knots.lastIndexOf(u);
  /** @type {Point[]} */
  const next = [];
  for (let i = 0; i <= points.length; i++) {
    if (i <= k - 3) next.push(points[i]);
    else if (i > k) next.push(points[i - 1]);
    else {
      const a = (u - knots[i]) / (knots[i + 3] - knots[i]);
      const [p, q] = [points[i - 1], points[i]];
      next.push([(1 - a) * p[0] + a * q[0], (1 - a) * p[1] + a * q[1]]);
    }
  }
  return [[...knots.slice(0, k + 1), u, ...knots.slice(k + 1)], next];
}

/**
 * Pieces of the natural cubic spline through points, one for each step: its slopes `m` have
 * m[i-1] + 4 m[i] + m[i+1] = 3 (p[i+1] - p[i-1]), and at its ends 2 m[0] + m[1] = 3 (p[1] - p[0]).
 * @param {Point[]} points  at least two
 * @returns {number[][]}
 */
export function piecesThrough(points) {
  const last = points.length - 1;
  /** @type {number[]} */
  const factors = [];
  /** @type {Point[]} */
  const slopes = [];
  points.forEach((_, i) => {
    const [left, right] = [points[Math.max(i - 1, 0)], points[Math.min(i + 1, last)]];
    const pivot = (i === 0 || i === last ? 2 : 4) - (i ? factors[i - 1] : 0);
    const before = i ? slopes[i - 1] : [0, 0];
    factors.push(1 / pivot);
    slopes.push([(3 * (right[0] - left[0]) - before[0]) / pivot, (3 * (right[1] - left[1]) - before[1]) / pivot]);
  });
  for (let i = last - 1; i >= 0; i--) {
    for (const k of /** @type {const} */ ([0, 1])) slopes[i][k] -= factors[i] * slopes[i + 1][k];
  }
  return points.slice(1).map((q, i) => {
    const [p, m, n] = [points[i], slopes[i], slopes[i + 1]];
    return [p[0], p[1], p[0] + m[0] / 3, p[1] + m[1] / 3, q[0] - n[0] / 3, q[1] - n[1] / 3, q[0], q[1]];
  });
}

/** @param {number[]} b @param {number} t @returns {Point} */
export function piecePoint(b, t) {
  const u = 1 - t;
  const [w0, w1, w2, w3] = [u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t];
  return [w0 * b[0] + w1 * b[2] + w2 * b[4] + w3 * b[6], w0 * b[1] + w1 * b[3] + w2 * b[5] + w3 * b[7]];
}

/** Unit direction; where poles are repeated, towards the next other one. @param {number[]} b @param {number} t @returns {Point} */
export function pieceTangent(b, t) {
  const d = derivative(b, t);
  if (Math.hypot(d[0], d[1]) > 1e-12) return unit(d);
  const e = derivative(b, t < 0.5 ? t + 1e-4 : t - 1e-4);
  return unit(e);
}

/** @param {number[]} b @param {number} t @returns {Point} */
function derivative(b, t) {
  const u = 1 - t;
  const [w0, w1, w2] = [3 * u * u, 6 * u * t, 3 * t * t];
  return [
    w0 * (b[2] - b[0]) + w1 * (b[4] - b[2]) + w2 * (b[6] - b[4]),
    w0 * (b[3] - b[1]) + w1 * (b[5] - b[3]) + w2 * (b[7] - b[5]),
  ];
}

/** Nearest point: samples, then bisection of the slope around the best. @param {number[]} b @param {Point} p */
export function pieceNearest(b, p) {
  const count = 24;
  let best = 0;
  let least = Infinity;
  for (let i = 0; i <= count; i++) {
    const q = piecePoint(b, i / count);
    const d = (q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2;
    if (d < least) [least, best] = [d, i];
  }
  let low = Math.max(best - 1, 0) / count;
  let high = Math.min(best + 1, count) / count;
  for (let i = 0; i < 40; i++) {
    const t = 0.5 * (low + high);
    const q = piecePoint(b, t);
    const d = derivative(b, t);
    if ((q[0] - p[0]) * d[0] + (q[1] - p[1]) * d[1] > 0) high = t;
    else low = t;
  }
  const t = 0.5 * (low + high);
  return { t, at: piecePoint(b, t) };
}

/** Rectangle around a piece: its ends and the extremes of both coordinates. @param {number[]} b */
export function pieceBounds(b) {
  /** @param {number} k @returns {[number, number]} */
  const range = (k) => {
    const [p, q, r, s] = [b[k], b[k + 2], b[k + 4], b[k + 6]];
    const a = s - 3 * r + 3 * q - p;
    const h = 2 * (r - 2 * q + p);
    const c = q - p;
    const roots = Math.abs(a) < 1e-14 ? [-c / h] : quadratic(a, h, c);
    const found = [p, s];
    for (const t of roots) if (t > 0 && t < 1) found.push(piecePoint(b, t)[k]);
    return [Math.min(...found), Math.max(...found)];
  };
  const [xmin, xmax] = range(0);
  const [ymin, ymax] = range(1);
  return { xmin, ymin, xmax, ymax };
}

/** Roots of a t^2 + b t + c. @param {number} a @param {number} b @param {number} c */
function quadratic(a, b, c) {
  const square = b * b - 4 * a * c;
  if (square < 0) return [];
  const q = -0.5 * (b + (b < 0 ? -1 : 1) * Math.sqrt(square));
  return [q / a, q === 0 ? 0 : c / q];
}
