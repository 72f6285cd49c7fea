/** Which part of the sketch is shown: scale, place of the origin, size of the canvas. */

/**
 * @typedef {import("./types.js").Point} Point
 * @typedef {{xmin: number, ymin: number, xmax: number, ymax: number}} Box
 * @typedef {{left: number, right: number, top: number, bottom: number}} Margins
 */

const SMALLEST = 1e-9;
const LARGEST = 1e9;

/** Event: "change". */
export class View extends EventTarget {
  /** Pixels per unit. */
  scale = 10;
  /** Pixels of the sketch's origin. */
  x = 0;
  y = 0;
  width = 1;
  height = 1;
  /** Whether the grid is shown and snapped to. */
  grid = true;
  /** Number that is shown for a length of 1: grid lines are at round numbers of those. */
  factor = 1;

  /**
   * Pixels of a point of the sketch.
   * @param {Point} p
   * @returns {Point}
   */
  toScreen(p) {
    return [this.x + this.scale * p[0], this.y - this.scale * p[1]];
  }

  /**
   * Point of the sketch at a pixel.
   * @param {Point} p
   * @returns {Point}
   */
  toWorld(p) {
    return [(p[0] - this.x) / this.scale, (this.y - p[1]) / this.scale];
  }

  /**
   * The canvas has another size: the middle stays.
   * @param {number} width
   * @param {number} height
   */
  resize(width, height) {
    this.x += (width - this.width) / 2;
    this.y += (height - this.height) / 2;
    this.width = width;
    this.height = height;
    this._changed();
  }

  /**
   * @param {number} dx  pixels
   * @param {number} dy
   */
  pan(dx, dy) {
    this.x += dx;
    this.y += dy;
    this._changed();
  }

  /**
   * Zoom about a pixel, which stays where it is.
   * @param {number} x
   * @param {number} y
   * @param {number} factor  more than 1 enlarges
   */
  zoomAt(x, y, factor) {
    const scale = Math.min(Math.max(this.scale * factor, SMALLEST), LARGEST);
    const f = scale / this.scale;
    this.x = x + f * (this.x - x);
    this.y = y + f * (this.y - y);
    this.scale = scale;
    this._changed();
  }

  /**
   * Put a point of the sketch into the middle.
   * @param {Point} p
   */
  centre(p) {
    this.x = this.width / 2 - this.scale * p[0];
    this.y = this.height / 2 + this.scale * p[1];
    this._changed();
  }

  /**
   * Show a rectangle of the sketch whole; null shows the origin at a usual scale.
   * @param {Box|null} box
   * @param {Margins} [margins]  pixels that stay free
   */
  fit(box, { left, right, top, bottom } = { left: 70, right: 70, top: 70, bottom: 70 }) {
    if (!box) {
      this.scale = 10;
      this.centre([0, 0]);
      return;
    }
    const across = Math.max(this.width - left - right, 0.3 * this.width);
    const up = Math.max(this.height - top - bottom, 0.3 * this.height);
    const w = box.xmax - box.xmin;
    const h = box.ymax - box.ymin;
    const scale = Math.min(w > 0 ? across / w : Infinity, h > 0 ? up / h : Infinity);
    if (Number.isFinite(scale)) this.scale = Math.min(Math.max(scale, SMALLEST), LARGEST);
    this.x = (this.width + left - right) / 2 - (this.scale * (box.xmin + box.xmax)) / 2;
    this.y = (this.height + top - bottom) / 2 + (this.scale * (box.ymin + box.ymax)) / 2;
    this._changed();
  }

  /** Part of the sketch that is visible. @returns {Box} */
  get visible() {
    const [xmin, ymax] = this.toWorld([0, 0]);
    const [xmax, ymin] = this.toWorld([this.width, this.height]);
    return { xmin, ymin, xmax, ymax };
  }

  /** Distance of grid lines: 1, 2 or 5 times a power of ten as lengths are shown, at least `pixels` apart. */
  gridStep(pixels = 12) {
    const raw = (pixels * this.factor) / this.scale;
    const power = 10 ** Math.floor(Math.log10(raw));
    const multiple = [1, 2, 5, 10].find((f) => f * power >= raw * (1 - 1e-12)) ?? 10;
    return (multiple * power) / this.factor;
  }

  /** Show or hide the grid. @param {boolean} on */
  setGrid(on) {
    this.grid = on;
    this._changed();
  }

  _changed() {
    this.dispatchEvent(new Event("change"));
  }
}
