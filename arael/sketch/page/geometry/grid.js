/** Spatial index: names by the cells of a grid that their rectangles touch. */

/** @typedef {import("../view.js").Box} Box */

const MOST_CELLS = 256;

export class Grid {
  /** @type {Map<string, Set<string>>} */
  _cells = new Map();
  /** Names of rectangles that touch too many cells. @type {Set<string>} */
  _large = new Set();
  /** @type {Map<string, [number, number, number, number]|null>} */
  _ranges = new Map();

  /** @param {number} cell  side of a cell */
  constructor(cell) {
    this.cell = cell > 0 && Number.isFinite(cell) ? cell : 1;
  }

  /** @param {Box} box @returns {[number, number, number, number]} */
  _range(box) {
    const c = this.cell;
    return [Math.floor(box.xmin / c), Math.floor(box.ymin / c), Math.floor(box.xmax / c), Math.floor(box.ymax / c)];
  }

  /**
   * Enter a name, or move it.
   * @param {string} name
   * @param {Box} box
   */
  put(name, box) {
    const range = this._range(box);
    const before = this._ranges.get(name);
    if (before && before.every((n, i) => n === range[i])) return;
    if (before !== undefined) this.remove(name);
    const [i0, j0, i1, j1] = range;
    if (!((i1 - i0 + 1) * (j1 - j0 + 1) <= MOST_CELLS)) {
      this._large.add(name);
      this._ranges.set(name, null);
      return;
    }
    this._ranges.set(name, range);
    for (let i = i0; i <= i1; i++) {
      for (let j = j0; j <= j1; j++) {
        const key = `${i},${j}`;
        const cell = this._cells.get(key);
        if (cell) cell.add(name);
        else this._cells.set(key, new Set([name]));
      }
    }
  }

  /** @param {string} name */
  remove(name) {
    const range = this._ranges.get(name);
    this._ranges.delete(name);
    this._large.delete(name);
    if (!range) return;
    const [i0, j0, i1, j1] = range;
    for (let i = i0; i <= i1; i++) {
      for (let j = j0; j <= j1; j++) this._cells.get(`${i},${j}`)?.delete(name);
    }
  }

  /**
   * Names whose cells a rectangle touches: a superset of those that it overlaps.
   * @param {Box} box
   * @returns {Set<string>}
   */
  near(box) {
    const found = new Set(this._large);
    const [i0, j0, i1, j1] = this._range(box);
    if ((i1 - i0 + 1) * (j1 - j0 + 1) > this._cells.size) {
      for (const name of this._ranges.keys()) found.add(name);
      return found;
    }
    for (let i = i0; i <= i1; i++) {
      for (let j = j0; j <= j1; j++) {
        const cell = this._cells.get(`${i},${j}`);
        if (cell) for (const name of cell) found.add(name);
      }
    }
    return found;
  }
}
