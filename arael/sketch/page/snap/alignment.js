/** Snaps to directions: level with a point, along or across a line, and to the grid. */

import { add, dot, sub, times } from "../geometry/vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("./candidates.js").Candidate} Candidate
 * @typedef {{name: string, direction: Point}} Reference  a line, its unit direction
 * @typedef {Candidate & {guides: [Point, Point][]}} Aligned
 */

/**
 * Directions from the start of a new line: horizontal, vertical, parallel and perpendicular to others.
 * @param {Point} from
 * @param {Point} at
 * @param {number} reach
 * @param {Reference[]} references
 * @returns {Aligned[]}
 */
export function directions(from, at, reach, references) {
  /** @type {{direction: Point, extra: string, handles: string[]}[]} */
  const all = [
    { direction: [1, 0], extra: "horizontal {c}", handles: [] },
    { direction: [0, 1], extra: "vertical {c}", handles: [] },
  ];
  for (const { name, direction: [x, y] } of references) {
    all.push({ direction: [x, y], extra: `parallel {c} ${name}`, handles: [name] });
    all.push({ direction: [-y, x], extra: `perpendicular {c} ${name}`, handles: [name] });
  }
  const v = sub(at, from);
  const length = Math.hypot(...v);
  /** @type {Aligned[]} */
  const found = [];
  for (const { direction, extra, handles } of all) {
    const p = add(from, times(direction, dot(v, direction)));
    const off = Math.hypot(at[0] - p[0], at[1] - p[1]);
    // close in pixels and in angle: short lines are not pulled
    if (off > reach || off > 0.06 * length || length === 0) continue;
    found.push({ kind: "alignment", at: p, handles, extras: [extra], guides: [[from, p]] });
  }
  return found;
}

/**
 * Places level with points: horizontally, vertically, or with one of each.
 * @param {{at: Point, handle: string}[]} points
 * @param {Point} at
 * @param {number} reach
 * @returns {Aligned|null}
 */
export function levels(points, at, reach) {
  /** @type {{at: Point, handle: string}|undefined} */
  let across;
  /** @type {{at: Point, handle: string}|undefined} */
  let up;
  for (const point of points) {
    if (Math.hypot(point.at[0] - at[0], point.at[1] - at[1]) < 2 * reach) continue;
    if (Math.abs(point.at[1] - at[1]) <= reach) across ??= point;
    else if (Math.abs(point.at[0] - at[0]) <= reach) up ??= point;
  }
  if (!across && !up) return null;
  /** @type {Point} */
  const p = [up ? up.at[0] : at[0], across ? across.at[1] : at[1]];
  const extras = [];
  const handles = [];
  /** @type {[Point, Point][]} */
  const guides = [];
  for (const [word, point] of /** @type {const} */ ([["horizontal", across], ["vertical", up]])) {
    if (!point) continue;
    guides.push([point.at, p]);
    if (!point.handle) continue;
    handles.push(point.handle);
    extras.push(`${word} {p} ${point.handle}`);
  }
  return { kind: "alignment", at: p, handles, extras, guides };
}

/**
 * The grid's nearest crossing; null if it is too far.
 * @param {Point} at
 * @param {number} step
 * @param {number} reach
 * @returns {Candidate|null}
 */
export function onGrid(at, step, reach) {
  /** @type {Point} */
  const p = [gridded(at[0], step), gridded(at[1], step)];
  if (Math.hypot(p[0] - at[0], p[1] - at[1]) > reach) return null;
  return { kind: "grid", at: p, handles: [], extras: [] };
}

/** Nearest multiple of a step, without the noise of its product. @param {number} x @param {number} step */
export function gridded(x, step) {
  return Number((Math.round(x / step) * step).toPrecision(12));
}
