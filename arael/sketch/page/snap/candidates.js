/** Places that a pointer can snap to on the geometry near it: points, middles, quadrants, crossings, feet. */

import { angleAt, conicPoint, isOn } from "../geometry/conics.js";
import { curveOf, lineEnds, nearest, pointAt } from "../geometry/curves.js";
import { pointHandles } from "../geometry/handles.js";
import { crossings } from "../geometry/intersect.js";
import { dist, foot, sub } from "../geometry/vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {import("../types.js").Conic} Conic
 * @typedef {import("../types.js").Entity} Entity
 * @typedef {import("../types.js").SnapKind} SnapKind
 * @typedef {{kind: SnapKind, at: Point, handles: string[], extras: string[]}} Candidate
 */

/** Crossings are looked for among at most so many curves. */
const MOST_CROSSED = 8;

/**
 * Candidates of the entities near a place.
 * @param {Entity[]} entities
 * @param {import("../store.js").Store} store
 * @param {Point} at
 * @param {number} reach
 * @param {import("../tools/tool.js").SnapContext} context
 * @returns {Candidate[]}
 */
export function candidates(entities, store, at, reach, context) {
  /** @type {Candidate[]} */
  const found = [];
  /** @type {{name: string, curve: Curve}[]} */
  const curves = [];
  for (const entity of entities) {
    points(entity, store, found);
    const curve = curveOf(entity, store.values);
    if (!curve) continue;
    const close = nearest(curve, at).distance <= reach;
    if (close) curves.push({ name: entity.name, curve });
    middles(entity, curve, found);
    if (close) onCurve(entity.name, curve, at, context, found);
  }
  crossed(curves.slice(0, MOST_CROSSED), found);
  return found.filter((one) => dist(one.at, at) <= reach);
}

/** @param {Entity} entity @param {import("../store.js").Store} store @param {Candidate[]} found */
function points(entity, store, found) {
  for (const handle of pointHandles(entity)) {
    const at = store.point(handle);
    const kind = handle.endsWith(".center") ? "centre" : "endpoint";
    if (at) found.push({ kind, at, handles: [handle], extras: [`coincident {p} ${handle}`] });
  }
}

/** @param {Entity} entity @param {Curve} curve @param {Candidate[]} found */
function middles(entity, curve, found) {
  const { name } = entity;
  if (entity.kind === "line" || entity.kind === "arc") {
    found.push({ kind: "midpoint", at: pointAt(curve, 0.5), handles: [name], extras: [`midpoint {p} ${name}`] });
  }
  if (curve.type !== "conic") return;
  for (let k = 0; k < 4; k++) {
    const angle = (k * Math.PI) / 2;
    if (!curve.closed && !isOn(curve, angle)) continue;
    const extras = [`point_on {p} ${name}`];
    // of a circle: level with its centre
    if (curve.rx === curve.ry) extras.push(`${k % 2 ? "vertical" : "horizontal"} {p} ${name}.center`);
    found.push({ kind: "quadrant", at: conicPoint(curve, angle), handles: [name], extras });
  }
}

/** @param {string} name @param {Curve} curve @param {Point} at @param {import("../tools/tool.js").SnapContext} context @param {Candidate[]} found */
function onCurve(name, curve, at, context, found) {
  const on = `point_on {p} ${name}`;
  if (context.from && context.draws === "line") {
    if (curve.type === "line") {
      const p = foot(context.from, ...lineEnds(curve));
      if (dist(p, context.from) > 0 && nearest(curve, p).distance < 1e-9 * (1 + Math.hypot(...p))) {
        found.push({ kind: "perpendicular", at: p, handles: [name], extras: [on, `perpendicular {c} ${name}`] });
      }
    } else if (curve.type === "conic" && curve.rx === curve.ry) {
      for (const p of tangentPoints(curve, context.from)) {
        found.push({ kind: "tangent", at: p, handles: [name], extras: [on, `tangent {c} ${name}`] });
      }
    }
  }
  found.push({ kind: "nearest", at: nearest(curve, at).at, handles: [name], extras: [on] });
}

/** Where tangents from a point touch a circle or arc. @param {Conic} c @param {Point} from @returns {Point[]} */
function tangentPoints(c, from) {
  const d = dist(from, [c.cx, c.cy]);
  if (d <= c.rx) return [];
  const [x, y] = sub(from, [c.cx, c.cy]);
  const base = Math.atan2(y, x);
  const half = Math.acos(c.rx / d);
  return [base - half, base + half].map((angle) => conicPoint(c, angle)).filter((p) => isOn(c, angleAt(c, p)));
}

/** @param {{name: string, curve: Curve}[]} curves @param {Candidate[]} found */
function crossed(curves, found) {
  for (let i = 0; i < curves.length; i++) {
    for (let j = 0; j < i; j++) {
      const [a, b] = [curves[j], curves[i]];
      for (const at of crossings(a.curve, b.curve)) {
        const extras = [`point_on {p} ${a.name}`, `point_on {p} ${b.name}`];
        found.push({ kind: "intersection", at, handles: [a.name, b.name], extras });
      }
    }
  }
}
