/** Curves of some entities, moved, turned or scaled, for previews. */

import { boundsOfSome } from "../geometry/boxes.js";
import { curveOf, spline } from "../geometry/curves.js";
import { add, turned } from "../geometry/vectors.js";

/**
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {import("../types.js").Point} Point
 */

/**
 * @param {import("../store.js").Store} store
 * @param {string[]} names
 */
export function copies(store, names) {
  const curves = names.flatMap((name) => {
    const entity = store.entities.get(name);
    const curve = entity && curveOf(entity, store.values);
    return curve ? [curve] : [];
  });
  const box = boundsOfSome(store, names);
  /** @type {Point} */
  const middle = box ? [(box.xmin + box.xmax) / 2, (box.ymin + box.ymax) / 2] : [0, 0];
  return {
    middle,
    /** @param {Point} by */
    moved: (by) => curves.map((curve) => mapped(curve, (p) => add(p, by), 0, 1)),
    /** @param {Point} centre @param {number} angle */
    turned: (centre, angle) => curves.map((curve) => mapped(curve, (p) => turned(p, centre, angle), angle, 1)),
    /** @param {Point} centre @param {number} factor */
    scaled: (centre, factor) =>
      curves.map((curve) =>
        mapped(curve, (p) => [centre[0] + factor * (p[0] - centre[0]), centre[1] + factor * (p[1] - centre[1])], 0, factor),
      ),
  };
}

/** @param {Curve} c @param {(p: Point) => Point} map @param {number} angle @param {number} factor @returns {Curve} */
function mapped(c, map, angle, factor) {
  if (c.type === "line") {
    const [a, b] = [map([c.x1, c.y1]), map([c.x2, c.y2])];
    return { type: "line", x1: a[0], y1: a[1], x2: b[0], y2: b[1] };
  }
  if (c.type === "spline") return spline(c.poles.map(map));
  const [cx, cy] = map([c.cx, c.cy]);
  return { ...c, cx, cy, rx: factor * c.rx, ry: factor * c.ry, turn: c.turn + angle };
}
