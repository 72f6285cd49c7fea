/** Regions: what curves enclose that meet at their ends, touch or cross, and the ends that meet nothing. */

import { overlap } from "./boxes.js";
import { boundsOf, curveOf, isClosed, nearest, pointAt, roughLength } from "./curves.js";
import { crossings } from "./intersect.js";
import { dist, sub } from "./vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {{name: string, curve: Curve, from: number, to: number}} Part  of a curve, between two parameters
 * @typedef {object} Loop  a closed way along curves, counter-clockwise
 * @property {string[]} names  of the entities
 * @property {Part[]} parts
 * @property {Point[]} polygon  for a first look
 * @property {number} area  of its inside
 * @property {number} length
 * @typedef {{loops: Loop[], openEnds: Point[]}} Regions
 * @typedef {Part & {ends: [number, number]}} Edge  ends: numbers of nodes
 */

/** Larger drawings have no regions: they are found anew after each change. */
export const MOST = 2000;
/** In larger drawings curves meet at their ends alone. */
const MOST_CROSSING = 400;
/** Ends this near, as a part of the drawing, meet. */
const NEAR = 1e-6;
/** Pieces of a curve; areas of half as many and of these are extrapolated. */
const PIECES = 128;

/**
 * The loops of the outline: construction, texts and points do not count.
 * @param {import("../store.js").Store} store
 * @returns {Regions}
 */
export function regionsOf(store) {
  /** @type {Loop[]} */
  const loops = [];
  /** @type {Part[]} */
  const whole = [];
  if (store.entities.size > MOST) return { loops, openEnds: [] };
  for (const entity of store.entities.values()) {
    const curve = entity.construction || entity.text ? null : curveOf(entity, store.values);
    if (curve && roughLength(curve) > 0) whole.push({ name: entity.name, curve, from: 0, to: 1 });
  }
  const size = whole.reduce((most, { curve }) => Math.max(most, ...pointAt(curve, 0).map(Math.abs), roughLength(curve)), 0);
  const near = NEAR * size;
  /** @type {Part[]} */
  const open = [];
  for (const part of whole.length > MOST_CROSSING ? whole : cut(whole, near)) {
    if (isClosed(part.curve) && part.to - part.from === 1 && part.from === 0) loops.push(loopOf([part]));
    else open.push(part);
  }
  const { edges, nodes } = joined(open, near);
  const openEnds = prune(edges, nodes);
  for (const way of faces(edges.filter((edge) => edge.ends[0] >= 0))) {
    const loop = loopOf(way);
    if (loop.area > 0) loops.push(loop);
  }
  return { loops, openEnds };
}

/** Curves cut where others cross them or end on them. @param {Part[]} whole @param {number} near @returns {Part[]} */
function cut(whole, near) {
  const boxes = whole.map(({ curve }) => boundsOf(curve));
  /** @type {number[][]} */
  const cuts = whole.map(() => []);
  /** @param {number} i @param {Point} p */
  const at = (i, p) => {
    const { t, distance } = nearest(whole[i].curve, p);
    if (distance <= near) cuts[i].push(t);
  };
  whole.forEach(({ curve: a }, i) => {
    for (let j = 0; j < i; j++) {
      const { curve: b } = whole[j];
      if (!overlap(boxes[i], boxes[j])) continue;
      for (const p of crossings(a, b)) {
        at(i, p);
        at(j, p);
      }
      if (!isClosed(a)) for (const t of [0, 1]) at(j, pointAt(a, t));
      if (!isClosed(b)) for (const t of [0, 1]) at(i, pointAt(b, t));
    }
  });
  return whole.flatMap((part, i) => pieces(part, cuts[i], near));
}

/** @param {Part} part @param {number[]} cuts @param {number} near @returns {Part[]} */
function pieces(part, cuts, near) {
  const { curve } = part;
  /** @type {number[]} */
  const inner = [];
  for (const t of cuts.sort((a, b) => a - b)) {
    const p = pointAt(curve, t);
    const known = isClosed(curve) ? inner.slice(0, 1) : [0, 1];
    if ([...known, ...inner.slice(-1)].every((other) => dist(pointAt(curve, other), p) > near)) inner.push(t);
  }
  if (!inner.length) return [part];
  const all = isClosed(curve) ? [...inner, inner[0] + 1] : [0, ...inner, 1];
  return all.slice(1).map((to, i) => ({ ...part, from: all[i], to }));
}

/** Edges between numbered places. @param {Part[]} open @param {number} near */
function joined(open, near) {
  const cell = near || 1;
  /** @type {Point[]} */
  const nodes = [];
  /** @type {Map<string, number>} */
  const byCell = new Map();
  /** @param {Point} p */
  const node = (p) => {
    const [i, j] = [Math.round(p[0] / cell), Math.round(p[1] / cell)];
    for (const di of [0, -1, 1]) {
      for (const dj of [0, -1, 1]) {
        const known = byCell.get(`${i + di} ${j + dj}`);
        if (known !== undefined && dist(nodes[known], p) <= cell) return known;
      }
    }
    byCell.set(`${i} ${j}`, nodes.length);
    return nodes.push(p) - 1;
  };
  /** @type {Edge[]} */
  const edges = open.map((part) => ({ ...part, ends: [node(pointAt(part.curve, part.from)), node(pointAt(part.curve, part.to))] }));
  return { edges, nodes };
}

/**
 * Take out what leads nowhere; its edges lose their ends.
 * @param {Edge[]} edges @param {Point[]} nodes
 * @returns {Point[]} ends that meet nothing, of chains of two curves or more
 */
function prune(edges, nodes) {
  /** @type {Set<Edge>[]} */
  const at = nodes.map(() => new Set());
  for (const edge of edges) for (const end of edge.ends) at[end].add(edge);
  const loose = at.flatMap((all, i) => (all.size === 1 && isLoose(all, i) ? [i] : []));
  const openEnds = loose.filter((i) => [...at[i]].some((edge) => edge.ends.some((end) => at[end].size > 1))).map((i) => nodes[i]);
  while (loose.length) {
    const i = /** @type {number} */ (loose.pop());
    for (const edge of at[i]) {
      for (const end of edge.ends) {
        at[end].delete(edge);
        if (end !== i && at[end].size === 1) loose.push(end);
      }
      edge.ends = [-1, -1];
    }
  }
  return openEnds;
}

/** Whether one edge ends here once. @param {Set<Edge>} all @param {number} i */
const isLoose = (all, i) => [...all].every(({ ends: [a, b] }) => (a === i) !== (b === i));

/**
 * Ways around each face, with the face on their left; that of the outside runs clockwise.
 * @param {Edge[]} edges
 * @returns {Part[][]}
 */
function faces(edges) {
  // Half edge 2 i runs along edge i, 2 i + 1 against it.
  /** @type {Map<number, {half: number, angle: number}[]>} */
  const leaving = new Map();
  edges.forEach(({ curve, from, to, ends }, i) => {
    for (const back of [0, 1]) {
      const [start, end] = back ? [to, from] : [from, to];
      const [x, y] = sub(pointAt(curve, start + 0.01 * (end - start)), pointAt(curve, start));
      const all = leaving.get(ends[back]) ?? [];
      leaving.set(ends[back], all);
      all.push({ half: 2 * i + back, angle: Math.atan2(y, x) });
    }
  });
  /** @type {number[]} */
  const next = [];
  for (const all of leaving.values()) {
    all.sort((a, b) => a.angle - b.angle);
    // Who arrives against a half edge goes on along the one before it, clockwise.
    all.forEach(({ half }, k) => (next[half ^ 1] = all[(k + all.length - 1) % all.length].half));
  }
  const seen = new Set();
  return next.flatMap((_, first) => {
    /** @type {Part[]} */
    const way = [];
    for (let half = first; !seen.has(half); half = next[half]) {
      seen.add(half);
      const { name, curve, from, to } = edges[half >> 1];
      way.push(half & 1 ? { name, curve, from: to, to: from } : { name, curve, from, to });
    }
    return way.length ? [way] : [];
  });
}

/** @param {Part[]} way @returns {Loop} */
function loopOf(way) {
  const [fine, rough] = [polygonOf(way, PIECES), polygonOf(way, PIECES / 2)];
  // Both errors fall with the square of the number of pieces.
  const extrapolated = (/** @type {(polygon: Point[]) => number} */ of) => (4 * of(fine) - of(rough)) / 3;
  return { names: way.map(({ name }) => name), parts: way, polygon: fine, area: extrapolated(areaOf), length: extrapolated(lengthOf) };
}

/** @param {Part[]} way @param {number} pieces */
function polygonOf(way, pieces) {
  return way.flatMap(({ curve, from, to }) => {
    const count = curve.type === "line" ? 1 : curve.type === "spline" ? pieces * curve.pieces.length : pieces;
    return Array.from({ length: count }, (_, i) => pointAt(curve, from + (i / count) * (to - from)));
  });
}

/** @param {Point[]} polygon */
function areaOf(polygon) {
  const [ox, oy] = polygon[0];
  return polygon.reduce((sum, [x, y], i) => {
    const [p, q] = polygon[(i + 1) % polygon.length];
    return sum + 0.5 * ((x - ox) * (q - oy) - (p - ox) * (y - oy));
  }, 0);
}

/** @param {Point[]} polygon */
const lengthOf = (polygon) => polygon.reduce((sum, p, i) => sum + dist(p, polygon[(i + 1) % polygon.length]), 0);

/** @param {Point[]} polygon @param {Point} p */
function holds(polygon, [x, y]) {
  let inside = false;
  polygon.forEach(([x1, y1], i) => {
    const [x2, y2] = polygon[(i + 1) % polygon.length];
    if (y1 > y !== y2 > y && x < x1 + ((y - y1) / (y2 - y1)) * (x2 - x1)) inside = !inside;
  });
  return inside;
}

/**
 * Area and perimeter of the region at a place, without what lies in its holes; null in a hole or outside.
 * @param {Loop[]} loops @param {Point} p
 * @returns {{area: number, perimeter: number}|null}
 */
export function regionAt(loops, p) {
  const around = loops.filter((loop) => holds(loop.polygon, p)).sort((a, b) => a.area - b.area);
  if (around.length % 2 === 0) return null;
  const [outer] = around;
  const inside = loops.filter((loop) => loop !== outer && loop.area < outer.area && holds(outer.polygon, loop.polygon[0]) && !around.includes(loop));
  const holes = inside.filter((loop) => !inside.some((other) => other !== loop && other.area > loop.area && holds(other.polygon, loop.polygon[0])));
  return {
    area: outer.area - holes.reduce((sum, loop) => sum + loop.area, 0),
    perimeter: outer.length + holes.reduce((sum, loop) => sum + loop.length, 0),
  };
}
