/**
 * Which part of a canvas was drawn on, so that only that is cleared: to clear all of a large canvas takes
 * as long as to draw two hundred lines on it, and what a drag moves is often long and thin.
 */

/** Pixels of the screen across a strip. */
export const STRIP = 64;
/** How far pens, halos, marks, arrows and badges reach from the places that are given, in pixels. */
const REACH = 12;

/** The highest and lowest pixel in each upright strip of the canvas. */
export class Swept {
  /** @type {Float64Array} */
  _tops = new Float64Array(0);
  _bottoms = this._tops;
  // of the drawing before this one
  _oldTops = this._tops;
  _oldBottoms = this._tops;
  _height = 0;
  _ratio = 1;

  /**
   * A drawing begins.
   * @param {number} width @param {number} height
   * @param {number} [ratio]  pixels of the screen for one of these, and of those that are given from now on
   */
  begin(width, height, ratio = 1) {
    const count = Math.ceil(Math.round(width * ratio) / STRIP);
    const fits = count === this._tops.length;
    const blank = (/** @type {Float64Array} */ old, /** @type {number} */ value) => (fits ? old : new Float64Array(count)).fill(value);
    const [tops, bottoms] = [this._oldTops, this._oldBottoms];
    // a canvas of another size is blank
    this._oldTops = fits ? this._tops : blank(tops, Infinity);
    this._oldBottoms = fits ? this._bottoms : blank(bottoms, -Infinity);
    this._tops = blank(tops, Infinity);
    this._bottoms = blank(bottoms, -Infinity);
    this._height = height;
    this._ratio = ratio;
  }

  /**
   * Something is drawn between two corners; what is outside of the canvas does not matter.
   * @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2
   * @param {number} [reach]  how far it may be drawn beside them
   */
  add(x1, y1, x2, y2, reach = REACH) {
    this.addEach([x1, y1, x2, y2], 1, reach);
  }

  /**
   * The same for each of several: x, y, x, y, ...
   * @param {ArrayLike<number>} corners @param {number} count @param {number} [reach]
   */
  addEach(corners, count, reach = REACH) {
    const { _tops: tops, _bottoms: bottoms } = this;
    const strip = STRIP / this._ratio;
    for (let k = 0; k < 4 * count; k += 4) {
      const x1 = corners[k];
      const y1 = corners[k + 1];
      const x2 = corners[k + 2];
      const y2 = corners[k + 3];
      const top = (y1 < y2 ? y1 : y2) - reach;
      const bottom = (y1 < y2 ? y2 : y1) + reach;
      const first = Math.max(Math.floor(((x1 < x2 ? x1 : x2) - reach) / strip), 0);
      const last = Math.min(Math.floor(((x1 < x2 ? x2 : x1) + reach) / strip), tops.length - 1);
      for (let i = first; i <= last; i++) {
        if (top < tops[i]) tops[i] = top;
        if (bottom > bottoms[i]) bottoms[i] = bottom;
      }
    }
  }

  /** Something is drawn whose place is not known. */
  addAll() {
    this._tops.fill(0);
    this._bottoms.fill(this._height);
  }

  /** Dimensions and badges are drawn. @param {import("./annotations.js").Shown} shown */
  addShown({ dimensions, glyphs }) {
    for (const { lines, thin, arcs, text, half } of dimensions) {
      for (const all of [lines, thin]) this.addEach(all, all.length / 4);
      for (const [x, y, r] of arcs) this.add(x - r, y - r, x + r, y + r);
      // a text may be turned
      this.add(text.x - half, text.y - half, text.x + half, text.y + half);
    }
    for (const { x, y } of glyphs) this.add(x, y, x, y);
  }

  /**
   * Rows of a strip between which is drawn, or was before this drawing; none if the second is not the larger.
   * @param {number} i @returns {[number, number]}
   */
  rows(i) {
    const top = this._ratio * Math.min(this._tops[i], this._oldTops[i]);
    const bottom = this._ratio * Math.max(this._bottoms[i], this._oldBottoms[i]);
    return [Math.max(Math.floor(top), 0), Math.min(Math.ceil(bottom), Math.round(this._ratio * this._height))];
  }

  /** Clear what was drawn, now and before. @param {CanvasRenderingContext2D} ctx  by pixels of the screen */
  clear(ctx) {
    for (let i = 0; i < this._tops.length; i++) {
      const [top, bottom] = this.rows(i);
      if (bottom > top) ctx.clearRect(i * STRIP, top, STRIP, bottom - top);
    }
  }
}
