/**
 * Which part of a canvas was drawn on, so that only that is cleared: to clear all of a large canvas takes
 * as long as to draw two hundred lines on it, and what a drag moves is often long and thin.
 */

/** Pixels across a strip. */
const STRIP = 64;
/** How far pens, halos, marks, arrows and badges reach from the places that are given, in pixels. */
const REACH = 12;

/** The highest and lowest pixel in each upright strip of the canvas. */
export class Swept {
  constructor() {
    this._tops = new Float64Array(0);
    this._bottoms = new Float64Array(0);
    this._height = 0;
  }

  /** The canvas is clear and of this size. @param {number} width @param {number} height */
  begin(width, height) {
    const count = Math.ceil(width / STRIP);
    if (count !== this._tops.length) [this._tops, this._bottoms] = [new Float64Array(count), new Float64Array(count)];
    this._tops.fill(Infinity);
    this._bottoms.fill(-Infinity);
    this._height = height;
  }

  /**
   * Something is drawn between two corners; what is outside of the canvas does not matter.
   * @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2
   * @param {number} [reach]  how far it may be drawn beside them
   */
  add(x1, y1, x2, y2, reach = REACH) {
    const top = (y1 < y2 ? y1 : y2) - reach;
    const bottom = (y1 < y2 ? y2 : y1) + reach;
    const first = Math.max(Math.floor(((x1 < x2 ? x1 : x2) - reach) / STRIP), 0);
    const last = Math.min(Math.floor(((x1 < x2 ? x2 : x1) + reach) / STRIP), this._tops.length - 1);
    for (let i = first; i <= last; i++) {
      if (top < this._tops[i]) this._tops[i] = top;
      if (bottom > this._bottoms[i]) this._bottoms[i] = bottom;
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
      for (const [x1, y1, x2, y2] of lines) this.add(x1, y1, x2, y2);
      for (const [x1, y1, x2, y2] of thin) this.add(x1, y1, x2, y2);
      for (const [x, y, r] of arcs) this.add(x - r, y - r, x + r, y + r);
      // a text may be turned
      this.add(text.x - half, text.y - half, text.x + half, text.y + half);
    }
    for (const { x, y } of glyphs) this.add(x, y, x, y);
  }

  /** Clear what was drawn. @param {CanvasRenderingContext2D} ctx  scaled by the pixel ratio */
  clear(ctx) {
    for (let i = 0; i < this._tops.length; i++) {
      const top = Math.max(Math.floor(this._tops[i]), 0);
      const bottom = Math.min(Math.ceil(this._bottoms[i]), this._height);
      if (bottom > top) ctx.clearRect(i * STRIP, top, STRIP, bottom - top);
    }
  }
}
