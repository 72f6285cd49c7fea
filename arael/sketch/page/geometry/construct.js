/** Constructions of the tools' previews: circles and arcs through points, tangent to lines. */

import { meet } from "./intersect.js";
import { add, angleOf, cross, dist, dot, foot, left, mix, positive, sub, times, unit } from "./vectors.js";
import { circle } from "./curves.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Conic} Conic
 */

/** Centre of the circle through three points; null if they are on a line. @param {Point} a @param {Point} b @param {Point} c @returns {Point|null} */
function circumcentre(a, b, c) {
  const p = mix(a, b, 0.5);
  const q = mix(b, c, 0.5);
  return meet(p, add(p, left(sub(b, a))), q, add(q, left(sub(c, b))));
}

/** Circle through three points. @param {Point} a @param {Point} b @param {Point} c @returns {Conic|null} */
export function circleThrough(a, b, c) {
  const m = circumcentre(a, b, c);
  return m && circle(m, dist(m, a));
}

/** Arc about a centre from one point to the direction of another. @param {Point} m @param {Point} from @param {Point} to @param {boolean} [clockwise] @returns {Conic} */
export function arcAbout(m, from, to, clockwise = false) {
  const r = dist(m, from);
  const start = angleOf(sub(from, m));
  const end = angleOf(sub(to, m));
  const sweep = clockwise ? -positive(start - end) : positive(end - start);
  return { ...circle(m, r), start, sweep, closed: false };
}

/** Arc from start to end through a third point. @param {Point} start @param {Point} end @param {Point} through @returns {Conic|null} */
export function arcThrough(start, end, through) {
  const m = circumcentre(start, through, end);
  if (!m) return null;
  return arcAbout(m, start, end, cross(sub(through, start), sub(end, start)) < 0);
}

/** Middle point of an arc. @param {Conic} c @returns {Point} */
export function arcMiddle(c) {
  const angle = c.start + 0.5 * c.sweep;
  return [c.cx + c.rx * Math.cos(angle), c.cy + c.rx * Math.sin(angle)];
}

/** Arc that leaves a point in a direction and ends at another. @param {Point} from @param {Point} direction @param {Point} to @returns {Conic|null} */
export function arcTangent(from, direction, to) {
  const chord = sub(to, from);
  const n = left(unit(direction));
  const across = dot(chord, n);
  if (Math.abs(across) < 1e-9 * Math.hypot(...chord)) return null;
  const radius = dot(chord, chord) / (2 * across);
  return arcAbout(add(from, times(n, radius)), from, to, radius < 0);
}

/**
 * Circle of a radius that touches two lines on the sides of a point.
 * @param {[Point, Point]} a @param {[Point, Point]} b @param {Point} near @param {number} radius
 * @returns {Conic|null}
 */
export function circleTouching(a, b, near, radius) {
  const shifted = [a, b].map(([p, q]) => {
    const n = left(unit(sub(q, p)));
    const side = dot(sub(near, p), n) < 0 ? -radius : radius;
    return /** @type {[Point, Point]} */ ([add(p, times(n, side)), add(q, times(n, side))]);
  });
  const m = meet(...shifted[0], ...shifted[1]);
  return m && circle(m, radius);
}

/** Circle inside the triangle of three lines. @param {[Point, Point][]} lines @returns {Conic|null} */
export function incircle(lines) {
  const [a, b, c] = [meet(...lines[1], ...lines[2]), meet(...lines[0], ...lines[2]), meet(...lines[0], ...lines[1])];
  if (!a || !b || !c) return null;
  const [u, v, w] = [dist(b, c), dist(a, c), dist(a, b)];
  const sum = u + v + w;
  /** @type {Point} */
  const m = [(u * a[0] + v * b[0] + w * c[0]) / sum, (u * a[1] + v * b[1] + w * c[1]) / sum];
  return circle(m, dist(m, foot(m, b, c)));
}

/** Corners of a rectangle on a first side, up to the height of a third point. @param {Point} a @param {Point} b @param {Point} c @returns {Point[]} */
export function rectangleOn(a, b, c) {
  const up = sub(c, foot(c, a, b));
  return [a, b, add(b, up), add(a, up)];
}

/** Arc of an ellipse by its frame and eccentric angles. @param {Point} m @param {number} rx @param {number} ry @param {number} turn @param {number} start @param {number} sweep @returns {Conic} */
export function ellipticArc(m, rx, ry, turn, start, sweep) {
  return { type: "conic", cx: m[0], cy: m[1], rx, ry, turn, start, sweep, closed: false };
}
