/** Finds what is under the pointer, within a tolerance in pixels, by a spatial index. */

import { boxOf, boundsOfAll, contains, overlap } from "./geometry/boxes.js";
import { curveOf, lineEnds, nearest, sample } from "./geometry/curves.js";
import { Grid } from "./geometry/grid.js";
import { pointHandles } from "./geometry/handles.js";
import { boxOfText, isInText } from "./geometry/lettering.js";

/**
 * @typedef {import("./types.js").Point} Point
 * @typedef {import("./types.js").Entity} Entity
 * @typedef {import("./view.js").Box} Box
 * @typedef {{name: string, type: "point"|"curve"|"constraint"|"dimension", distance: number}} Pick
 */

/** Tolerances in pixels. */
export const TOLERANCE = { mouse: 7, touch: 18 };

export class Picker {
  /** Reach of the pointer in pixels. @type {number} */
  tolerance = TOLERANCE.mouse;
  /** Glyphs and texts on the screen, set by the renderer. @type {() => import("./draw/places.js").Places<string>|null} */
  annotations = () => null;
  /** @type {Grid|null} */
  _grid = null;
  /** Whether numbers may have changed since rectangles were entered. */
  _stale = true;
  /** Entities that are new or have another place in the numbers. @type {Set<string>} */
  _fresh = new Set();
  /** Entity of each number; null: to be found again. @type {Entity[]|null} */
  _owners = null;
  /** The numbers whose rectangles are entered. */
  _entered = new Float64Array(0);

  /** @param {import("./store.js").Store} store @param {import("./view.js").View} view */
  constructor(store, view) {
    this.store = store;
    this.view = view;
  }

  /** Records changed. @param {import("./store.js").ChangeDetail} detail */
  changed(detail) {
    if (detail.all) this._grid = null;
    const removed = detail.removed.entities ?? [];
    const put = detail.put.entities ?? [];
    for (const name of removed) {
      this._grid?.remove(name);
      this._fresh.delete(name);
    }
    for (const { name } of put) this._fresh.add(name);
    if (removed.length || put.length) this._owners = null;
    this.moved();
  }

  /** Numbers changed. */
  moved() {
    this._stale = true;
  }

  /** The index, up to date. */
  get grid() {
    const { store } = this;
    if (!this._grid) {
      const box = boundsOfAll(store);
      const size = box ? Math.max(box.xmax - box.xmin, box.ymax - box.ymin) : 1;
      this._grid = new Grid(size / Math.min(Math.max(Math.sqrt(store.entities.size), 4), 200) || 1);
      this._owners = null;
      this._entered = new Float64Array(0);
      this._stale = true;
    }
    if (this._stale) this._enter(this._grid);
    return this._grid;
  }

  /** Enter the rectangles of what is new or has moved: numbers are compared with those at the last time. @param {Grid} grid */
  _enter(grid) {
    const { values, entities } = this.store;
    const owners = (this._owners ??= ownersOf(entities.values()));
    const before = this._entered;
    /** @type {Entity|null} */
    let last = null;
    for (let i = 0; i < owners.length; i++) {
      if (values[i] === before[i] || owners[i] === last || !owners[i]) continue;
      last = owners[i];
      grid.put(last.name, boxOf(last, values));
    }
    for (const name of this._fresh) {
      const entity = entities.get(name);
      if (entity) grid.put(name, boxOf(entity, values));
    }
    this._fresh.clear();
    if (before.length === values.length) before.set(values);
    else this._entered = values.slice();
    this._stale = false;
  }

  /** Entities whose rectangles may touch a circle around a point. @param {Point} at @param {number} reach @returns {Entity[]} */
  near(at, reach) {
    const box = { xmin: at[0] - reach, ymin: at[1] - reach, xmax: at[0] + reach, ymax: at[1] + reach };
    const found = [];
    for (const name of this.grid.near(box)) {
      const entity = this.store.entities.get(name);
      if (entity) found.push(entity);
    }
    return found;
  }

  /**
   * Everything at a pixel, the best first: texts and glyphs, then points, then curves.
   * @param {Point} screen
   * @param {(pick: Pick) => boolean} [accept]
   * @returns {Pick[]}
   */
  all(screen, accept = () => true) {
    const { store, view, tolerance } = this;
    const at = view.toWorld(screen);
    const reach = tolerance / view.scale;
    /** @type {Pick[]} */
    const found = [];
    for (const name of this.annotations()?.at(screen[0], screen[1], tolerance > 10 ? 8 : 0) ?? []) {
      found.push({ name, type: store.dimensions.has(name) ? "dimension" : "constraint", distance: 0 });
    }
    /** @type {Pick[]} */
    const points = [];
    /** @type {Pick[]} */
    const curves = [];
    for (const entity of this.near(at, reach)) {
      for (const handle of pointHandles(entity)) {
        const p = store.point(handle);
        const distance = p ? Math.hypot(p[0] - at[0], p[1] - at[1]) : Infinity;
        if (distance <= 1.2 * reach) points.push({ name: handle, type: "point", distance });
      }
      const curve = curveOf(entity, store.values);
      let distance = curve ? nearest(curve, at).distance : Infinity;
      // a text is picked by its lettering too, after the curves within it
      if (entity.text && curve?.type === "line" && isInText(entity.text, ...lineEnds(curve), at)) distance = Math.min(distance, reach);
      if (distance <= reach) curves.push({ name: entity.name, type: "curve", distance });
    }
    const by = (/** @type {Pick} */ a, /** @type {Pick} */ b) => a.distance - b.distance;
    return [...found, ...points.sort(by), ...curves.sort(by)].filter(accept);
  }

  /**
   * The best thing at a pixel.
   * @param {Point} screen
   * @param {(pick: Pick) => boolean} [accept]
   * @returns {Pick|null}
   */
  at(screen, accept) {
    return this.all(screen, accept)[0] ?? null;
  }

  /**
   * Entities in a box of the screen: inside it, or with `touched` also those that it crosses.
   * @param {Point} from
   * @param {Point} to
   * @param {boolean} touched
   * @returns {string[]}
   */
  inBox(from, to, touched) {
    const [a, b] = [this.view.toWorld(from), this.view.toWorld(to)];
    const box = {
      xmin: Math.min(a[0], b[0]), ymin: Math.min(a[1], b[1]),
      xmax: Math.max(a[0], b[0]), ymax: Math.max(a[1], b[1]),
    };
    const found = [];
    for (const name of this.grid.near(box)) {
      const entity = this.store.entities.get(name);
      if (entity && this._isIn(entity, box, touched)) found.push(name);
    }
    return found.sort(natural);
  }

  /** @param {Entity} entity @param {Box} box @param {boolean} touched */
  _isIn(entity, box, touched) {
    const own = boxOf(entity, this.store.values);
    if (contains(box, own)) return true;
    if (!touched || !overlap(box, own)) return false;
    const curve = curveOf(entity, this.store.values);
    if (!curve) return true;
    if (entity.text && curve.type === "line") {
      const corners = boxOfText(entity.text, ...lineEnds(curve));
      return corners.some((p, i) => crosses(p, corners[(i + 1) % 4], box));
    }
    const points = curve.type === "line" ? sample(curve, Infinity) : sample(curve, 3 / this.view.scale);
    return points.some((p, i) => crosses(points[Math.max(i - 1, 0)], p, box));
  }
}

/** Whether a segment touches a box (Liang and Barsky 1984). @param {Point} p @param {Point} q @param {Box} box */
function crosses(p, q, box) {
  let [low, high] = [0, 1];
  for (const [d, before, after] of [
    [q[0] - p[0], box.xmin - p[0], box.xmax - p[0]],
    [q[1] - p[1], box.ymin - p[1], box.ymax - p[1]],
  ]) {
    if (d === 0) {
      if (before > 0 || after < 0) return false;
      continue;
    }
    const [s, t] = d > 0 ? [before / d, after / d] : [after / d, before / d];
    low = Math.max(low, s);
    high = Math.min(high, t);
  }
  return low <= high;
}

/** @param {Iterable<Entity>} entities @returns {Entity[]} */
function ownersOf(entities) {
  /** @type {Entity[]} */
  const owners = [];
  for (const entity of entities) {
    for (let i = 0; i < entity.size; i++) owners[entity.at + i] = entity;
  }
  return owners;
}

/** L2 before L10. @param {string} a @param {string} b */
const natural = (a, b) => a.localeCompare(b, "en", { numeric: true });
