/** Circles, ellipses and their arcs: angles are eccentric angles, from the first axis. */

import { TAU, positive, signed, unit } from "./vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Conic} Conic
 */

/**
 * @param {"circle"|"arc"|"ellipse"|"earc"} kind
 * @param {Float64Array} v
 * @param {number} at
 * @returns {Conic}
 */
export function arcOf(kind, v, at) {
  const cx = v[at];
  const cy = v[at + 1];
  /** @type {Conic} */
  const c = { type: "conic", cx, cy, rx: 0, ry: 0, turn: 0, start: 0, sweep: TAU, closed: true };
  if (kind === "circle") c.rx = c.ry = v[at + 2];
  else if (kind === "arc") c.rx = c.ry = v[at + 6];
  else {
    const first = kind === "ellipse" ? at + 2 : at + 6;
    c.rx = v[first];
    c.ry = v[first + 1];
    c.turn = v[first + 2];
  }
  if (kind === "arc" || kind === "earc") {
    c.closed = false;
    c.start = angleAt(c, [v[at + 2], v[at + 3]]);
    c.sweep = positive(angleAt(c, [v[at + 4], v[at + 5]]) - c.start) || TAU;
  }
  return c;
}

/** Eccentric angle of the direction from the centre to a point. @param {Conic} c @param {Point} p */
export function angleAt(c, p) {
  const [x, y] = local(c, p);
  return c.rx === c.ry ? Math.atan2(y, x) : Math.atan2(y / (c.ry || 1), x / (c.rx || 1));
}

/** Coordinates in the frame of centre and axes. @param {Conic} c @param {Point} p @returns {Point} */
export function local(c, p) {
  const x = p[0] - c.cx;
  const y = p[1] - c.cy;
  if (!c.turn) return [x, y];
  const u = Math.cos(c.turn);
  const v = Math.sin(c.turn);
  return [u * x + v * y, u * y - v * x];
}

/** A vector of the frame as one of the plane. @param {Conic} c @param {number} x @param {number} y @returns {Point} */
function outer(c, x, y) {
  if (!c.turn) return [x, y];
  const u = Math.cos(c.turn);
  const v = Math.sin(c.turn);
  return [u * x - v * y, v * x + u * y];
}

/** Point at an angle. @param {Conic} c @param {number} angle @returns {Point} */
export function conicPoint(c, angle) {
  const [x, y] = outer(c, c.rx * Math.cos(angle), c.ry * Math.sin(angle));
  return [c.cx + x, c.cy + y];
}

/** Unit direction of travel at an angle. @param {Conic} c @param {number} angle @returns {Point} */
export function conicTangent(c, angle) {
  const s = c.sweep < 0 ? -1 : 1;
  return unit(outer(c, -s * c.rx * Math.sin(angle), s * c.ry * Math.cos(angle)));
}

/** Fraction of the sweep at an angle; outside of 0 .. 1 off an arc. @param {Conic} c @param {number} angle */
function parameterOf(c, angle) {
  if (c.closed) return positive(angle - c.start) / TAU;
  return 0.5 + signed(angle - c.start - 0.5 * c.sweep) / c.sweep;
}

/** Whether an angle lies on the arc. @param {Conic} c @param {number} angle @param {number} [slack] */
export function isOn(c, angle, slack = 1e-9) {
  const t = parameterOf(c, angle);
  return t >= -slack && t <= 1 + slack;
}

/** Nearest point. @param {Conic} c @param {Point} p @returns {{at: Point, t: number, distance: number}} */
export function conicNearest(c, p) {
  const angle = c.rx === c.ry ? angleAt(c, p) : ellipseFoot(c, p);
  const t = Math.min(Math.max(parameterOf(c, angle), 0), 1);
  let best = foot(c, p, t);
  if (!c.closed) for (const end of [0, 1]) if (foot(c, p, end).distance < best.distance) best = foot(c, p, end);
  return best;
}

/** @param {Conic} c @param {Point} p @param {number} t */
function foot(c, p, t) {
  const at = conicPoint(c, c.start + t * c.sweep);
  return { at, t, distance: Math.hypot(at[0] - p[0], at[1] - p[1]) };
}

/**
 * Angle of the nearest point of a whole ellipse: Newton's method on the derivative of the squared
 * distance, from the best of 16 starts, so that it does not end at another stationary point.
 * @param {Conic} c
 * @param {Point} p
 */
function ellipseFoot(c, p) {
  const [x, y] = local(c, p);
  let best = 0;
  let least = Infinity;
  for (let i = 0; i < 16; i++) {
    const a = (i * TAU) / 16;
    const d = (c.rx * Math.cos(a) - x) ** 2 + (c.ry * Math.sin(a) - y) ** 2;
    if (d < least) [least, best] = [d, a];
  }
  const k = c.ry * c.ry - c.rx * c.rx;
  for (let i = 0; i < 12; i++) {
    const s = Math.sin(best);
    const u = Math.cos(best);
    const slope = k * s * u + c.rx * x * s - c.ry * y * u;
    const bend = k * (u * u - s * s) + c.rx * x * u + c.ry * y * s;
    if (!(bend > 0)) break;
    const step = slope / bend;
    best -= step;
    if (Math.abs(step) < 1e-14) break;
  }
  return best;
}

/** Rectangle around an arc: its ends and the extremes that lie on it. @param {Conic} c */
export function conicBounds(c) {
  const hx = Math.hypot(c.rx * Math.cos(c.turn), c.ry * Math.sin(c.turn));
  const hy = Math.hypot(c.rx * Math.sin(c.turn), c.ry * Math.cos(c.turn));
  if (c.closed) return { xmin: c.cx - hx, ymin: c.cy - hy, xmax: c.cx + hx, ymax: c.cy + hy };
  const ax = Math.atan2(-c.ry * Math.sin(c.turn), c.rx * Math.cos(c.turn));
  const ay = Math.atan2(c.ry * Math.cos(c.turn), c.rx * Math.sin(c.turn));
  const angles = [c.start, c.start + c.sweep];
  for (const a of [ax, ax + Math.PI, ay, ay + Math.PI]) if (isOn(c, a)) angles.push(a);
  const points = angles.map((a) => conicPoint(c, a));
  const xs = points.map((p) => p[0]);
  const ys = points.map((p) => p[1]);
  return { xmin: Math.min(...xs), ymin: Math.min(...ys), xmax: Math.max(...xs), ymax: Math.max(...ys) };
}
