/** A dimension that a drag moves: where all that it belongs to moves alike, its lines and text move with it. */

import { POINTS, splitHandle } from "../geometry/handles.js";

/** Pixels by which places may differ that move alike. */
const ALIKE = 0.01;

/**
 * @typedef {import("./lines.js").Drawn} Drawn
 * @typedef {import("../types.js").Dimension} Dimension
 */

export class Follower {
  /** Offsets of the numbers that it depends on: x and y of points, then radii and angles. @type {number[]} */
  _at = [];
  /** These numbers when it was laid out. @type {number[]} */
  _before = [];
  /** @type {Drawn|null} */
  _drawn = null;
  // by how many pixels it was moved since
  _x = 0;
  _y = 0;

  /** @param {import("../store.js").Store} store @param {Dimension} record */
  constructor(store, record) {
    this.record = record;
    this._store = store;
    /** @type {number[]} */
    const rest = [];
    for (const arg of record.args) {
      const { kind, at, size } = /** @type {import("../types.js").Entity} */ (store.entities.get(splitHandle(arg)[0]));
      const placed = kind === "bezier" || kind === "bspline" ? size : 2 * Object.keys(POINTS[kind]).length;
      for (let i = 0; i < size; i++) (i < placed ? this._at : rest).push(at + i);
    }
    this._placed = this._at.length;
    this._at.push(...rest);
  }

  /** As it is now. @param {number} scale  pixels per unit @param {() => Drawn|null} layout */
  drawn(scale, layout) {
    const { _store: { values }, _at: at, _before: before } = this;
    if (this._drawn && this._movesAlike(scale)) {
      const x = scale * (values[at[0]] - before[0]);
      const y = scale * (before[1] - values[at[1]]);
      shift(this._drawn, x - this._x, y - this._y);
      [this._x, this._y] = [x, y];
    } else {
      this._drawn = layout();
      this._before = at.map((one) => values[one]);
      this._x = this._y = 0;
    }
    return this._drawn;
  }

  /** @param {number} scale */
  _movesAlike(scale) {
    const { _store: { values }, _at: at, _before: before, _placed: placed } = this;
    for (let i = 0; i < at.length; i++) {
      const by = i < placed ? values[at[i % 2]] - before[i % 2] : 0;
      if (Math.abs(values[at[i]] - before[i] - by) > ALIKE / scale) return false;
    }
    return true;
  }
}

/** @param {Drawn} drawn @param {number} x @param {number} y */
function shift({ lines, thin, arrows, arcs, text }, x, y) {
  for (const all of [lines, thin, arrows]) {
    for (let k = 0; k < all.length; k += 2) {
      all[k] += x;
      all[k + 1] += y;
    }
  }
  for (const one of arcs) {
    one[0] += x;
    one[1] += y;
  }
  text.x += x;
  text.y += y;
}
