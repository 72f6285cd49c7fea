/** Crossings of curves: in closed form for lines and circles, by samples and Newton's method otherwise. */

import { angleAt, isOn } from "./conics.js";
import { lineEnds, nearest, pointAt, sample, tangentAt } from "./curves.js";
import { add, cross, dist, dot, sub, times, unit } from "./vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {import("../types.js").Line} Line
 * @typedef {import("../types.js").Conic} Conic
 */

/**
 * Where two lines meet, extended; null if they are parallel.
 * @param {Point} a @param {Point} b @param {Point} c @param {Point} d
 * @returns {Point|null}
 */
export function meet(a, b, c, d) {
  const u = sub(b, a);
  const v = sub(d, c);
  const w = cross(u, v);
  if (Math.abs(w) <= 1e-12 * Math.hypot(...u) * Math.hypot(...v)) return null;
  return add(a, times(u, cross(sub(c, a), v) / w));
}

/**
 * Points where two curves cross, within their ends.
 * @param {Curve} a
 * @param {Curve} b
 * @returns {Point[]}
 */
export function crossings(a, b) {
  if (a.type === "line" && b.type === "line") return lines(a, b);
  if (a.type === "line" && isRound(b)) return lineCircle(a, b);
  if (b.type === "line" && isRound(a)) return lineCircle(b, a);
  if (isRound(a) && isRound(b)) return circles(a, b);
  return sampled(a, b);
}

/** @param {Curve} c @returns {c is Conic} */
const isRound = (c) => c.type === "conic" && c.rx === c.ry;

/** @param {Line} a @param {Line} b @returns {Point[]} */
function lines(a, b) {
  const [p, q] = lineEnds(a);
  const [r, s] = lineEnds(b);
  const at = meet(p, q, r, s);
  return at && between(at, p, q) && between(at, r, s) ? [at] : [];
}

/** @param {Point} at @param {Point} p @param {Point} q */
function between(at, p, q) {
  const d = sub(q, p);
  const t = dot(sub(at, p), d) / dot(d, d);
  return t >= -1e-9 && t <= 1 + 1e-9;
}

/** @param {Line} l @param {Conic} c @returns {Point[]} */
function lineCircle(l, c) {
  const [p, q] = lineEnds(l);
  const d = unit(sub(q, p));
  /** @type {Point} */
  const centre = [c.cx, c.cy];
  const along = dot(sub(centre, p), d);
  const foot = add(p, times(d, along));
  const square = c.rx * c.rx - dist(foot, centre) ** 2;
  if (square < 0) return [];
  const half = Math.sqrt(square);
  const found = half > 0 ? [add(foot, times(d, -half)), add(foot, times(d, half))] : [foot];
  return found.filter((at) => between(at, p, q) && isOn(c, angleAt(c, at)));
}

/** @param {Conic} a @param {Conic} b @returns {Point[]} */
function circles(a, b) {
  const d = Math.hypot(b.cx - a.cx, b.cy - a.cy);
  if (d === 0 || d > a.rx + b.rx || d < Math.abs(a.rx - b.rx)) return [];
  const along = (d * d + a.rx * a.rx - b.rx * b.rx) / (2 * d);
  const half = Math.sqrt(Math.max(a.rx * a.rx - along * along, 0));
  const [ux, uy] = [(b.cx - a.cx) / d, (b.cy - a.cy) / d];
  /** @type {Point[]} */
  const found = [-half, half].map((h) => [a.cx + along * ux - h * uy, a.cy + along * uy + h * ux]);
  return found.filter((at) => isOn(a, angleAt(a, at)) && isOn(b, angleAt(b, at)));
}

/** @param {Curve} a @param {Curve} b @returns {Point[]} */
function sampled(a, b) {
  const p = sample(a, Infinity);
  const q = sample(b, Infinity);
  /** @type {Point[]} */
  const found = [];
  for (let i = 1; i < p.length; i++) {
    for (let j = 1; j < q.length; j++) {
      const at = meet(p[i - 1], p[i], q[j - 1], q[j]);
      if (!at || !between(at, p[i - 1], p[i]) || !between(at, q[j - 1], q[j])) continue;
      const exact = polished(a, b, at);
      if (!found.some((other) => dist(other, exact) < 1e-9 * (1 + Math.hypot(...exact)))) found.push(exact);
    }
  }
  return found;
}

/**
 * Crossing of the tangents at the nearest points, repeated.
 * @param {Curve} a @param {Curve} b @param {Point} at
 * @returns {Point}
 */
function polished(a, b, at) {
  for (let i = 0; i < 8; i++) {
    const u = nearest(a, at);
    const v = nearest(b, at);
    const p = pointAt(a, u.t);
    const q = pointAt(b, v.t);
    const next = meet(p, add(p, tangentAt(a, u.t)), q, add(q, tangentAt(b, v.t)));
    if (!next) return at;
    const step = dist(next, at);
    at = next;
    if (step < 1e-13 * (1 + Math.hypot(...at))) break;
  }
  return at;
}
