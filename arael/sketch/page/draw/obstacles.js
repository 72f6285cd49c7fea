/** Marks places of the geometry as taken, so that texts and badges keep off it. */

import { boxOf, overlap } from "../geometry/boxes.js";
import { curveOf, lineEnds, roughLength, sample } from "../geometry/curves.js";
import { boxOfText } from "../geometry/lettering.js";

/**
 * @typedef {import("../view.js").View} View
 * @typedef {import("./places.js").Places<string>} Places
 */

/** With more curves than this in sight none is marked: they are short on the screen, and marking takes long. */
const MOST_CURVES = 1000;

/**
 * Mark the points, curves and texts that are in sight.
 * @param {import("../store.js").Store} store @param {View} view @param {Places} places
 */
export function takeCurves(store, view, places) {
  const { visible, width, height } = view;
  const seen = [...store.entities.values()].filter((one) => overlap(visible, boxOf(one, store.values)));
  if (seen.length > MOST_CURVES) return;
  for (const entity of seen) {
    const curve = curveOf(entity, store.values);
    if (!curve) {
      const [x, y] = view.toScreen(store.point(entity.name) ?? [NaN, NaN]);
      if (x > 0 && y > 0 && x < width && y < height) places.take(x, y, 4, 4);
      continue;
    }
    const step = Math.max(12 / view.scale, roughLength(curve) / 150);
    for (const p of sample(curve, step)) {
      const [x, y] = view.toScreen(p);
      if (x > 0 && y > 0 && x < width && y < height) places.take(x, y, 3, 3);
    }
    if (entity.text && curve.type === "line") takeText(boxOfText(entity.text, ...lineEnds(curve)), view, places);
  }
}

/**
 * Mark the box of a text: squares along its middle.
 * @param {import("../types.js").Point[]} box @param {View} view @param {Places} places
 */
function takeText(box, view, places) {
  const [a, b, , d] = box.map((p) => view.toScreen(p));
  const half = Math.hypot(d[0] - a[0], d[1] - a[1]) / 2;
  if (!half || 2 * half > view.height) return;
  const count = Math.min(Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / half / 2), 200);
  for (let i = 0; i < count; i++) {
    const [x, y] = [0, 1].map((k) => (a[k] + d[k]) / 2 + ((i + 0.5) / count) * (b[k] - a[k]));
    if (x > 0 && y > 0 && x < view.width && y < view.height) places.take(x, y, half, half);
  }
}
