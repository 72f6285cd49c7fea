/** Turns a pixel into a place of the sketch: ten kinds of snap, with the constraints that follow from each. */

import { curveOf, tangentAt } from "../geometry/curves.js";
import { dist } from "../geometry/vectors.js";
import { directions, gridded, levels, onGrid } from "./alignment.js";
import { candidates } from "./candidates.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Snap} Snap
 * @typedef {import("../types.js").SnapKind} SnapKind
 * @typedef {import("../tools/tool.js").SnapContext} SnapContext
 * @typedef {import("./candidates.js").Candidate} Candidate
 */

/** Snaps of a lower rank win over nearer ones. @type {Record<SnapKind, number>} */
export const RANKS = {
  endpoint: 0, centre: 1, intersection: 1, midpoint: 2, tangent: 2, perpendicular: 2, quadrant: 3,
  nearest: 5, alignment: 4, grid: 6,
};

/** In words. @type {Record<SnapKind, string>} */
export const WORDS = {
  endpoint: "endpoint", centre: "centre", midpoint: "middle", quadrant: "quadrant", intersection: "crossing",
  nearest: "on", tangent: "tangent to", perpendicular: "perpendicular to", alignment: "in line with", grid: "grid",
};

/** Reach of a snap in pixels. */
const REACH = 10;
const MOST_RECENT = 3;

export class Snapper {
  /** Handles of points that the pointer touched lately: others align with them. @type {string[]} */
  recent = [];
  /** Kinds that are switched off. @type {Set<SnapKind>} */
  off = new Set();

  /**
   * @param {import("../store.js").Store} store
   * @param {import("../view.js").View} view
   * @param {import("../pick.js").Picker} picker
   */
  constructor(store, view, picker) {
    this.store = store;
    this.view = view;
    this.picker = picker;
  }

  /**
   * Place of a pixel.
   * @param {Point} screen
   * @param {SnapContext} context
   * @param {{bare?: boolean, free?: boolean}} [options]  without automatic constraints; without snaps
   * @returns {Place}
   */
  place(screen, context, options = {}) {
    const bare = !!options.bare;
    const at = this.view.toWorld(screen);
    const found = options.free ? null : this._best(at, context);
    if (!found) return { at: rounded(at, this.view.scale), snap: null, screen, bare };
    if (found.kind === "endpoint" || found.kind === "centre") this._remember(found.handles[0]);
    const extras = bare ? [] : [...found.extras, ...this._level(found, context)];
    const names = found.handles.join(" and ");
    /** @type {Snap} */
    const snap = { kind: found.kind, handles: found.handles, text: `${WORDS[found.kind]} ${names}`.trim(), extras };
    if ("guides" in found) snap.guides = /** @type {[Point, Point][]} */ (found.guides);
    return { at: found.at, snap, screen, bare };
  }

  /** @param {Point} at @param {SnapContext} context @returns {Candidate|null} */
  _best(at, context) {
    const reach = (REACH * (this.picker.tolerance > 10 ? 2 : 1)) / this.view.scale;
    const near = candidates(this.picker.near(at, 1.5 * reach), this.store, at, reach, context);
    const directed = context.from && context.draws === "line" ? directions(context.from, at, reach, this._references(context)) : [];
    const all = [...near, ...directed].filter((one) => !this.off.has(one.kind));
    // a foot on a curve is anywhere along it: a better defined place close by wins
    const level = all.length ? null : this._levels(at, context, 0.7 * reach);
    if (level && !this.off.has("alignment")) all.push(level);
    const rank = (/** @type {Candidate} */ one) => RANKS[one.kind] + dist(one.at, at) / reach;
    all.sort((a, b) => rank(a) - rank(b));
    if (all.length) return this._gridded(all[0], at, reach);
    if (!this.view.grid || this.off.has("grid")) return null;
    return onGrid(at, this.view.gridStep(), 0.7 * reach);
  }

  /** An aligned place at a round coordinate of the grid, if that is near. @param {Candidate} found @param {Point} at @param {number} reach @returns {Candidate} */
  _gridded(found, at, reach) {
    if (found.kind !== "alignment" || !this.view.grid || found.extras.length !== 1) return found;
    const word = found.extras[0].split(" ")[0];
    if (word !== "horizontal" && word !== "vertical") return found;
    const axis = word === "horizontal" ? 0 : 1;
    const value = gridded(at[axis], this.view.gridStep());
    if (Math.abs(value - at[axis]) > 0.7 * reach) return found;
    /** @type {Point} */
    const p = axis ? [found.at[0], value] : [value, found.at[1]];
    return { ...found, at: p };
  }

  /** @param {Point} at @param {SnapContext} context @param {number} reach */
  _levels(at, context, reach) {
    const points = this.recent
      .map((handle) => ({ handle, at: this.store.point(handle) }))
      .filter((one) => one.at !== null)
      .map(({ handle, at: p }) => ({ handle, at: /** @type {Point} */ (p) }));
    for (const p of context.extra ?? []) points.push({ handle: "", at: p });
    return levels(points, at, reach);
  }

  /** A new line that ends on a point and is level by itself. @param {Candidate} found @param {SnapContext} context */
  _level(found, context) {
    if (!context.from || context.draws !== "line" || found.kind === "alignment") return [];
    const dx = Math.abs(found.at[0] - context.from[0]);
    const dy = Math.abs(found.at[1] - context.from[1]);
    if (dy <= 1e-6 * dx && dx > 0) return ["horizontal {c}"];
    return dx <= 1e-6 * dy && dy > 0 ? ["vertical {c}"] : [];
  }

  /** Lines that a new one may be parallel or perpendicular to. @param {SnapContext} context */
  _references(context) {
    return (context.lines ?? []).flatMap((name) => {
      const entity = this.store.entities.get(name);
      const curve = entity && curveOf(entity, this.store.values);
      if (!curve || curve.type !== "line") return [];
      const direction = tangentAt(curve, 0);
      const level = Math.abs(direction[0]) < 1e-9 || Math.abs(direction[1]) < 1e-9;
      return level ? [] : [{ name, direction }];
    });
  }

  /** @param {string} handle */
  _remember(handle) {
    this.recent = [handle, ...this.recent.filter((one) => one !== handle)].slice(0, MOST_RECENT);
  }
}

/** A free place, to a tenth of a pixel in round digits. @param {Point} p @param {number} scale @returns {Point} */
export function rounded(p, scale) {
  const step = 10 ** Math.floor(Math.log10(0.5 / scale));
  return [gridded(p[0], step), gridded(p[1], step)];
}
