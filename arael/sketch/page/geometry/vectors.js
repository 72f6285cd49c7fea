/** Vectors of the plane as pairs of numbers. */

/** @typedef {import("../types.js").Point} Point */

export const TAU = 2 * Math.PI;

/** @param {Point} a @param {Point} b @returns {Point} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1]];

/** @param {Point} a @param {Point} b @returns {Point} */
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1]];

/** @param {Point} a @param {number} f @returns {Point} */
export const times = (a, f) => [a[0] * f, a[1] * f];

/** @param {Point} a @param {Point} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1];

/** @param {Point} a @param {Point} b */
export const cross = (a, b) => a[0] * b[1] - a[1] * b[0];

/** @param {Point} a @param {Point} b */
export const dist = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** The vector turned left by a right angle. @param {Point} a @returns {Point} */
export const left = (a) => [-a[1], a[0]];

/** Point at a fraction from a to b. @param {Point} a @param {Point} b @param {number} t @returns {Point} */
export const mix = (a, b, t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];

/** Unit vector; of a vector of length zero the x axis. @param {Point} a @returns {Point} */
export function unit(a) {
  const length = Math.hypot(a[0], a[1]);
  return length > 0 ? [a[0] / length, a[1] / length] : [1, 0];
}

/** Unit vector at an angle in radians. @param {number} angle @returns {Point} */
export const polar = (angle) => [Math.cos(angle), Math.sin(angle)];

/** Angle of a vector from the x axis, radians. @param {Point} a */
export const angleOf = (a) => Math.atan2(a[1], a[0]);

/** Point turned about a centre. @param {Point} p @param {Point} c @param {number} angle @returns {Point} */
export function turned(p, c, angle) {
  const [x, y] = sub(p, c);
  const [u, v] = polar(angle);
  return [c[0] + u * x - v * y, c[1] + v * x + u * y];
}

/** Angle in 0 .. 2 pi. @param {number} angle */
export const positive = (angle) => ((angle % TAU) + TAU) % TAU;

/** Angle in -pi .. pi. @param {number} angle */
export const signed = (angle) => positive(angle + Math.PI) - Math.PI;

/** Foot of a point on the line through a and b, extended. @param {Point} p @param {Point} a @param {Point} b @returns {Point} */
export function foot(p, a, b) {
  const d = sub(b, a);
  const square = dot(d, d);
  return square > 0 ? add(a, times(d, dot(sub(p, a), d) / square)) : a;
}

/** Point on the other side of the line through a and b. @param {Point} p @param {Point} a @param {Point} b @returns {Point} */
export function mirrored(p, a, b) {
  const f = foot(p, a, b);
  return [2 * f[0] - p[0], 2 * f[1] - p[1]];
}
