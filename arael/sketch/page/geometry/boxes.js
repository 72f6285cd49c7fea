/** Rectangles around entities. */

import { boundsOf, curveOf, lineEnds } from "./curves.js";
import { boxOfText } from "./lettering.js";

/**
 * @typedef {import("../view.js").Box} Box
 * @typedef {import("../types.js").Entity} Entity
 */

/**
 * @param {Entity} entity
 * @param {Float64Array} values
 * @returns {Box}
 */
export function boxOf(entity, values) {
  const curve = curveOf(entity, values);
  if (curve?.type === "line" && entity.text) return boxAround(boxOfText(entity.text, ...lineEnds(curve)));
  if (curve) return boundsOf(curve);
  const [x, y] = [values[entity.at], values[entity.at + 1]];
  return { xmin: x, ymin: y, xmax: x, ymax: y };
}

/** @param {import("../types.js").Point[]} points @returns {Box} */
function boxAround(points) {
  const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
  return { xmin: Math.min(...xs), ymin: Math.min(...ys), xmax: Math.max(...xs), ymax: Math.max(...ys) };
}

/**
 * Rectangle around everything; null for an empty sketch.
 * @param {import("../store.js").Store} store
 * @returns {Box|null}
 */
export function boundsOfAll(store) {
  return boundsOfSome(store, store.entities.keys());
}

/**
 * Rectangle around some entities.
 * @param {import("../store.js").Store} store
 * @param {Iterable<string>} names
 * @returns {Box|null}
 */
export function boundsOfSome(store, names) {
  /** @type {Box|null} */
  let found = null;
  for (const name of names) {
    const entity = store.entities.get(name);
    if (!entity) continue;
    const box = boxOf(entity, store.values);
    found = found ? joined(found, box) : box;
  }
  return found;
}

/** @param {Box} a @param {Box} b @returns {Box} */
export function joined(a, b) {
  return {
    xmin: Math.min(a.xmin, b.xmin), ymin: Math.min(a.ymin, b.ymin),
    xmax: Math.max(a.xmax, b.xmax), ymax: Math.max(a.ymax, b.ymax),
  };
}

/** @param {Box} outer @param {Box} inner */
export const contains = (outer, inner) =>
  inner.xmin >= outer.xmin && inner.xmax <= outer.xmax && inner.ymin >= outer.ymin && inner.ymax <= outer.ymax;

/** @param {Box} a @param {Box} b */
export const overlap = (a, b) => a.xmin <= b.xmax && a.xmax >= b.xmin && a.ymin <= b.ymax && a.ymax >= b.ymin;
