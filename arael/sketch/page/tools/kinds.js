/** Kinds of dimensions that fit what is picked; the first is the one that the pointer's place suggests. */

import { curveOf } from "../geometry/curves.js";
import { meet } from "../geometry/intersect.js";
import { cross, sub } from "../geometry/vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").EntityKind} EntityKind
 * @typedef {{kind: string, args: string[], mode?: string}} Choice
 */

const ROUND = ["circle", "arc", "ellipse", "earc"];

/**
 * @param {import("../store.js").Store} store
 * @param {string[]} names  one or two entities or points
 * @param {Point} at  of the pointer
 * @returns {Choice[]}
 */
export function kindsOf(store, names, at) {
  const kinds = names.map((name) => (store.point(name) ? "point" : store.entities.get(name)?.kind));
  if (names.length === 1) return ofOne(store, names[0], kinds[0], at);
  if (names.length !== 2) return [];
  return ofTwo(store, names, kinds, at);
}

/** @param {import("../store.js").Store} store @param {string} name @param {EntityKind|undefined} kind @param {Point} at @returns {Choice[]} */
function ofOne(store, name, kind, at) {
  const all = (/** @type {string[]} */ ...words) => words.map((word) => ({ kind: word, args: [name] }));
  switch (kind) {
    case "line": {
      const ends = [`${name}.p1`, `${name}.p2`];
      const direct = { kind: "length", args: [name] };
      const [a, b] = ends.map((end) => store.point(end));
      const level = a && b && (a[0] === b[0] || a[1] === b[1]);
      const sided = a && b && !level ? between(a, b, at, ends, direct) : [direct];
      return [...sided, ...all("xangle")];
    }
    case "circle":
      return all("diameter", "radius");
    case "arc":
      return all("radius", "sweep", "arc_length", "diameter");
    case "ellipse":
    case "earc":
      return all("radius", "radius_b", "xangle");
    default:
      return kind === "bezier" || kind === "bspline" ? all("total_length") : [];
  }
}

/** Whether a direction lies in one of the two sectors beside that from u to v and its opposite. @param {Point} w @param {Point} u @param {Point} v */
const isOutside = (w, u, v) => cross(u, w) * cross(w, v) < 0;

/** Direct, along x or along y: as the pointer lies to the two points. @param {Point} a @param {Point} b @param {Point} at @param {string[]} args @param {Choice} direct @returns {Choice[]} */
function between(a, b, at, args, direct) {
  const inX = at[0] > Math.min(a[0], b[0]) && at[0] < Math.max(a[0], b[0]);
  const inY = at[1] > Math.min(a[1], b[1]) && at[1] < Math.max(a[1], b[1]);
  const across = { kind: "hdistance", args };
  const up = { kind: "vdistance", args };
  if (inX && !inY) return [across, direct, up];
  return inY && !inX ? [up, direct, across] : [direct, across, up];
}

/** @param {import("../store.js").Store} store @param {string[]} names @param {(EntityKind|undefined)[]} kinds @param {Point} at @returns {Choice[]} */
function ofTwo(store, names, kinds, at) {
  // a circle stands for its centre, unless both are concentric
  const points = names.map((name, i) => (ROUND.includes(kinds[i] ?? "") ? `${name}.center` : name));
  const [p, q] = points.map((handle) => store.point(handle));
  const [a, b] = names.map((name) => {
    const entity = store.entities.get(name);
    return entity ? curveOf(entity, store.values) : null;
  });
  if (p && q) {
    if (a?.type === "conic" && b?.type === "conic" && Math.hypot(p[0] - q[0], p[1] - q[1]) < 1e-9 * (a.rx + b.rx)) {
      return [{ kind: "distance", args: names }];
    }
    const direct = { kind: "distance", args: points };
    return p[0] === q[0] || p[1] === q[1] ? [direct] : between(p, q, at, points, direct);
  }
  if (a?.type === "line" && b?.type === "line") {
    const [u, v] = [a, b].map((c) => /** @type {Point} */ (sub([c.x2, c.y2], [c.x1, c.y1])));
    const parallel = Math.abs(cross(u, v)) < 1e-3 * Math.hypot(...u) * Math.hypot(...v);
    if (parallel) return [{ kind: "distance", args: names }];
    const inner = { kind: "angle", args: names };
    const outer = { ...inner, mode: "supplement" };
    const vertex = meet([a.x1, a.y1], [a.x2, a.y2], [b.x1, b.y1], [b.x2, b.y2]);
    return vertex && isOutside(sub(at, vertex), u, v) ? [outer, inner] : [inner, outer];
  }
  if (p && b?.type === "line") return [{ kind: "distance", args: [points[0], names[1]] }];
  if (q && a?.type === "line") return [{ kind: "distance", args: [points[1], names[0]] }];
  return [];
}
