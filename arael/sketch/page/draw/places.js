/** Rectangles on the screen that are taken, so that texts and glyphs do not overlap; found by cells. */

/** @typedef {import("../types.js").Point} Point */

const CELL = 32;

/** @template T @typedef {{x: number, y: number, w: number, h: number, item: T|null}} Taken */

/** @template T */
export class Places {
  /** @type {Map<number, Taken<T>[]>} */
  _cells = new Map();
  /** How often `isFree` was asked since `choosing`, and what it answered last. */
  _asked = 0;
  _free = true;

  /** @param {Places<T>|null} [below]  places that are taken as well */
  constructor(below = null) {
    this._below = below;
  }

  /** Something begins to look for its place. @param {string} _key */
  choosing(_key) {
    this._asked = 0;
    this._free = true;
  }

  /** How many places were refused since `choosing`, before one was taken; -1 if all were. */
  get refused() {
    return this._free ? Math.max(this._asked - 1, 0) : -1;
  }

  /**
   * Whether a rectangle of half sizes w, h overlaps none that is taken, and a line that goes with it passes
   * through no text or badge.
   * @param {number} x @param {number} y @param {number} w @param {number} h
   * @param {() => [Point, Point]} [line]
   */
  isFree(x, y, w, h, line) {
    this._asked++;
    this._free = this._isFree(x, y, w, h) && !(line && this._passesThrough(...line()));
    return this._free;
  }

  /** Whether a line passes through something that can be picked. @param {Point} p @param {Point} q */
  _passesThrough(p, q) {
    const count = Math.min(Math.ceil(Math.hypot(q[0] - p[0], q[1] - p[1]) / 6), 300);
    for (let i = 0; i <= count; i++) {
      const [x, y] = [0, 1].map((k) => p[k] + (i / Math.max(count, 1)) * (q[k] - p[k]));
      if (this.at(x, y, 1).length) return true;
    }
    return false;
  }

  /** @param {number} x @param {number} y @param {number} w @param {number} h @returns {boolean} */
  _isFree(x, y, w, h) {
    for (const key of cells(x, y, w, h)) {
      for (const o of this._cells.get(key) ?? []) {
        if (Math.abs(x - o.x) < w + o.w && Math.abs(y - o.y) < h + o.h) return false;
      }
    }
    return this._below?._isFree(x, y, w, h) ?? true;
  }

  /**
   * Mark a rectangle as taken, by something or by nothing that can be picked.
   * @param {number} x @param {number} y @param {number} w @param {number} h
   * @param {T|null} [item]
   */
  take(x, y, w, h, item = null) {
    const taken = { x, y, w, h, item };
    for (const key of cells(x, y, w, h)) {
      const cell = this._cells.get(key);
      if (cell) cell.push(taken);
      else this._cells.set(key, [taken]);
    }
  }

  /** Badges, and texts of other dimensions, keep off lines. @param {number[]} lines  x, y, x, y of each */
  takeLines(lines) {
    for (let k = 0; k < lines.length; k += 4) {
      const [x1, y1, x2, y2] = lines.slice(k, k + 4);
      const count = Math.min(Math.ceil(Math.hypot(x2 - x1, y2 - y1) / 16), 100);
      for (let i = 1; i < count; i++) this.take(x1 + (i / count) * (x2 - x1), y1 + (i / count) * (y2 - y1), 3, 3);
    }
  }

  /**
   * The first free place; the first one if none is.
   * @param {Point[]} spots
   * @param {number} w @param {number} h
   */
  firstFree(spots, w, h) {
    return spots.find(([x, y]) => this.isFree(x, y, w, h)) ?? spots[0];
  }

  /**
   * Items within `slack` pixels of a point, the nearest centre first.
   * @param {number} x @param {number} y @param {number} [slack]
   * @returns {T[]}
   */
  at(x, y, slack = 0) {
    /** @type {Map<T, number>} */
    const found = new Map();
    for (const key of cells(x, y, slack, slack)) {
      for (const o of this._cells.get(key) ?? []) {
        if (o.item && Math.abs(x - o.x) <= o.w + slack && Math.abs(y - o.y) <= o.h + slack) {
          found.set(o.item, Math.hypot(x - o.x, y - o.y));
        }
      }
    }
    return [...found].sort((a, b) => a[1] - b[1]).map(([item]) => item);
  }
}

/**
 * The choices of an earlier layout again: while a drag moves things, their texts and badges stay on the
 * side and level where they are, and nothing is compared.
 * @template T
 * @extends {Places<T>}
 */
export class SamePlaces extends Places {
  _left = 0;

  /** @param {ReadonlyMap<string, number>} choices  `refused` by key */
  constructor(choices) {
    super();
    this._choices = choices;
  }

  /** @override @param {string} key */
  choosing(key) {
    this._left = this._choices.get(key) ?? 0;
  }

  /** @override */
  isFree() {
    return this._left-- === 0;
  }

  /** @override */
  take() {}

  /** @override */
  takeLines() {}
}

/** @param {number} x @param {number} y @param {number} w @param {number} h */
function cells(x, y, w, h) {
  const keys = [];
  for (let i = Math.floor((x - w) / CELL); i <= Math.floor((x + w) / CELL); i++) {
    for (let j = Math.floor((y - h) / CELL); j <= Math.floor((y + h) / CELL); j++) keys.push(i * 65536 + j);
  }
  return keys;
}
