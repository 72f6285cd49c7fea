/** Badges of constraints beside what they act on: laid out without overlaps, hidden where too small or without a free place. */

import { angleAt, conicPoint } from "../geometry/conics.js";
import { curveOf, isClosed, lineEnds, nearest, pointAt, roughLength, tangentAt } from "../geometry/curves.js";
import { meet } from "../geometry/intersect.js";
import { splitHandle } from "../geometry/handles.js";
import { left } from "../geometry/vectors.js";
import { EDGES } from "./palette.js";
import { drawBadge } from "./symbols.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Curve} Curve
 * @typedef {import("../types.js").Constraint} Constraint
 * @typedef {{at: Point, normal: Point|null, size: number}} Anchor  in the sketch; size of what it belongs to
 * @typedef {{name: string, of: string, kind: string, x: number, y: number, ring: boolean}} Glyph  in pixels; the name
 *     of a constraint, or of the group to which the constraint `of` belongs
 * @typedef {{store: import("../store.js").Store, view: import("../view.js").View, nudged?: Map<string, Point>}} Scene
 * @typedef {import("./places.js").Places<string>} Places
 */

export const HALF = 8;
/** What is shorter on the screen, in pixels, has no badge. */
const SMALLEST = 30;
const MOST = 1200;
const ON_BOTH = new Set(["parallel", "equal", "collinear", "equal_angle", "symmetry", "image", "concentric"]);

/**
 * Constraints that something is to be said about: of a conflict, named, or on what is named.
 * @param {import("../store.js").Store} store
 * @param {Iterable<string>} names  of constraints, entities, points, dimensions, groups
 * @returns {Constraint[]}
 */
export function constraintsOf(store, names) {
  const wanted = new Set(names);
  for (const name of [...wanted]) for (const one of store.groups.get(name)?.owned ?? []) wanted.add(one);
  const { constraints: conflicts } = store.verdict;
  if (!wanted.size && !Object.keys(conflicts).length) return [];
  const fits = (/** @type {string} */ arg) => wanted.has(arg) || wanted.has(splitHandle(arg)[0]);
  return [...store.constraints.values()].filter(({ name, args }) => wanted.has(name) || name in conflicts || args.some(fits));
}

/** The group of each constraint that belongs to one. @param {import("../store.js").Store} store @returns {Map<string, string>} */
function groupsOf(store) {
  const found = new Map();
  for (const { name, owned } of store.groups.values()) for (const one of owned ?? []) found.set(one, name);
  return found;
}

/**
 * Badges of the constraints that are visible and large enough; of a group one, by the group's name.
 * @param {Scene} scene
 * @param {Places} places
 * @param {ReadonlySet<string>} always  names that are shown at any size
 * @param {Iterable<Constraint>} [constraints]  all
 * @param {Map<string, number>} [choices]  which of the possible places each has, by name and anchor; that is
 *     preferred, and written anew
 * @returns {Glyph[]}
 */
export function layoutGlyphs(scene, places, always, constraints = scene.store.constraints.values(), choices = undefined) {
  const { store, view } = scene;
  const groups = groupsOf(store);
  /** @type {Set<string>} */
  const said = new Set();
  /** @type {Glyph[]} */
  const found = [];
  for (const constraint of constraints) {
    const { name: of, kind } = constraint;
    const wanted = always.has(of);
    const group = wanted ? undefined : groups.get(of);
    const name = group ?? of;
    if (group && (kind === "coincident" || said.has(group))) continue;
    if (found.length > MOST && !wanted) continue;
    const marks = anchors(constraint, store).slice(0, group ? 1 : undefined);
    for (const [i, anchor] of marks.entries()) {
      if (anchor.size * view.scale < SMALLEST && !wanted) continue;
      const [x, y] = view.toScreen(anchor.at);
      if (x < -40 || y < -40 || x > view.width + 40 || y > view.height + 40) continue;
      if (kind === "coincident") {
        found.push({ name, of, kind, x, y, ring: true });
        continue;
      }
      const key = `${name} ${i}`;
      const by = scene.nudged?.get(name);
      const spots = around(x, y, anchor.normal);
      places.choosing(key);
      const before = choices?.get(key) ?? -1;
      const order = before > 0 ? [spots[before], ...spots] : spots;
      /** @type {Point|undefined} */
      const at = by ? [spots[0][0] + by[0], spots[0][1] + by[1]] : order.find(([u, v]) => places.isFree(u, v, HALF + 1, HALF + 1));
      choices?.set(key, at ? Math.max(spots.indexOf(at), 0) : -1);
      // there is no place that is clear of geometry, texts and other badges
      if (!at) continue;
      places.take(...at, HALF + 1, HALF + 1, name);
      found.push({ name, of, kind, x: at[0], y: at[1], ring: false });
      if (group) said.add(group);
    }
  }
  return found;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Glyph} glyph
 * @param {{state: string, active: boolean, hovered: boolean}} look
 * @param {import("./palette.js").Palette} palette
 */
export function drawGlyph(ctx, glyph, look, palette) {
  const colours = /** @type {Record<string, string>} */ (palette);
  const strong = look.state ? colours[look.state] : look.hovered ? palette.preview : "";
  ctx.globalAlpha = look.active ? 1 : 0.45;
  if (glyph.ring) {
    if (strong) {
      ctx.beginPath();
      ctx.arc(glyph.x, glyph.y, 7, 0, 2 * Math.PI);
      ctx.strokeStyle = strong;
      ctx.lineWidth = 1.8;
      ctx.setLineDash(EDGES[look.state] ?? []);
      ctx.stroke();
      ctx.setLineDash([]);
    }
  } else {
    drawBadge(ctx, glyph.kind, glyph.x, glyph.y, {
      half: HALF,
      back: palette["glyph-back"],
      edge: strong || palette["glyph-edge"],
      ink: strong || palette.glyph,
      width: strong ? 1.8 : 0.9,
      dash: EDGES[look.state] ?? [],
    });
  }
  ctx.globalAlpha = 1;
}

/**
 * Where a constraint is shown.
 * @param {Constraint} constraint
 * @param {import("../store.js").Store} store
 * @returns {Anchor[]}
 */
export function anchors(constraint, store) {
  const { kind, args } = constraint;
  if (kind === "perpendicular" || kind === "tangent") {
    const [a, b] = args.map((arg) => curveNamed(store, arg));
    const at = a && b ? meeting(a, b) : null;
    if (a && b && at) return [{ at, normal: null, size: Math.min(roughLength(a), roughLength(b)) }];
  }
  const found = args.map((arg) => anchor(store, arg)).filter((one) => one !== null);
  if (!ON_BOTH.has(kind)) return found.slice(0, 1);
  return kind === "symmetry" ? found.filter((_, i) => i !== 1) : found;
}

/** @param {import("../store.js").Store} store @param {string} name @returns {Curve|null} */
function curveNamed(store, name) {
  const entity = store.entities.get(name);
  return entity ? curveOf(entity, store.values) : null;
}

/** @param {import("../store.js").Store} store @param {string} handle @returns {Anchor|null} */
function anchor(store, handle) {
  const curve = curveNamed(store, handle);
  if (curve) {
    const t = isClosed(curve) ? 0.125 : 0.5;
    return { at: pointAt(curve, t), normal: left(tangentAt(curve, t)), size: roughLength(curve) };
  }
  const at = store.point(handle);
  if (!at) return null;
  const owner = curveNamed(store, splitHandle(handle)[0]);
  return { at, normal: null, size: owner ? roughLength(owner) : Infinity };
}

/** Where two curves touch or cross, if that is on or near both. @param {Curve} a @param {Curve} b @returns {Point|null} */
function meeting(a, b) {
  /** @type {Point|null} */
  let at = null;
  if (a.type === "line" && b.type === "line") at = meet(...lineEnds(a), ...lineEnds(b));
  else if (a.type === "conic" || b.type === "conic") {
    const conic = a.type === "conic" ? a : b;
    const other = a.type === "conic" ? b : a;
    if (conic.type !== "conic") return null;
    at = nearest(other, [conic.cx, conic.cy]).at;
    if (other.type === "conic") at = conicPoint(conic, angleAt(conic, [other.cx, other.cy]));
  }
  if (!at) return null;
  const p = at;
  const reach = 0.05 * Math.max(roughLength(a), roughLength(b));
  return [a, b].every((curve) => nearest(curve, p).distance <= reach) ? p : null;
}

/** Places beside an anchor, the best first. @param {number} x @param {number} y @param {Point|null} normal @returns {Point[]} */
function around(x, y, normal) {
  /** @type {Point[]} */
  const spots = [];
  if (!normal) {
    for (const r of [16, 25, 35, 47, 60]) {
      for (const k of [1, 3, 5, 7, 0, 2, 4, 6]) {
        spots.push([x + r * Math.cos((k * Math.PI) / 4), y - r * Math.sin((k * Math.PI) / 4)]);
      }
    }
    return spots;
  }
  const [nx, ny] = [normal[0], -normal[1]];
  for (const level of [14, 32, 50, 68]) {
    for (const slide of [0, 19, -19, 38, -38, 57, -57]) {
      for (const side of [1, -1]) {
        spots.push([x + side * level * nx + slide * ny, y + side * level * ny - slide * nx]);
      }
    }
  }
  return spots;
}
