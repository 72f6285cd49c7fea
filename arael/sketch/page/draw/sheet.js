/**
 * A drawing by hand: straight lines and marks as numbers of pixels, which a canvas takes over as they are.
 * Without a graphics processor the browser notes every call first and carries it out later; for many short
 * lines and small marks both together take four times as long as to fill in their pixels here.
 *
 * Pixels lie in upright strips, one after the other, so that the part of a strip that is drawn on is one
 * run of numbers. How much of a pixel a line covers is its area, as of the browser's own lines.
 */

import { STRIP } from "./swept.js";

/** Two to this power: `STRIP`. */
const SHIFT = 6;
/** Pixels by which the ends of a line may differ that is drawn as upright or level. */
const NEARLY = 0.02;
/** Sine of a direction that is nearly level. */
const LEVEL = 0.01;

export class Sheet {
  width = 0;
  height = 0;
  ratio = 1;
  /** What lies below, without holes. @type {HTMLCanvasElement|null} */
  below = null;
  /** The drawing, then what lies below. */
  _pixels = new Int32Array(0);
  /** @type {ImageData[]} */
  _strips = [];
  /** Pixels by colour. @type {Map<string, number>} */
  _colours = new Map();

  /**
   * Begin a drawing of this size, in pixels of the screen.
   * @param {number} width @param {number} height
   * @param {number} ratio  of them for one of those that lines are given in
   */
  begin(width, height, ratio) {
    this.ratio = ratio;
    if (width === this.width && height === this.height) return;
    const [size, count] = [STRIP * height, Math.ceil(width / STRIP)];
    [this.width, this.height] = [width, height];
    const bytes = new Uint8ClampedArray(8 * size * count);
    this._pixels = new Int32Array(bytes.buffer);
    this.below = null;
    this._strips = Array.from({ length: count }, (_, i) =>
      new ImageData(bytes.subarray(4 * size * i, 4 * size * (i + 1)), STRIP, height));
  }

  /** Begin an empty drawing over a canvas of this size, as it is now, or over nothing. @param {HTMLCanvasElement|null} below */
  lay(below) {
    const { width, height, _pixels: pixels } = this;
    const half = pixels.length / 2;
    this.below = below;
    if (!below) pixels.fill(0);
    else {
      const ctx = scratch(width, height);
      ctx.drawImage(below, 0, 0);
      for (let at = 0, x = 0; at < half; at += STRIP * height, x += STRIP) {
        pixels.set(new Int32Array(ctx.getImageData(x, 0, STRIP, height).data.buffer), half + at);
      }
      pixels.copyWithin(0, half);
    }
  }

  /** The pixel that a colour fills. @param {string} colour */
  colour(colour) {
    let found = this._colours.get(colour);
    if (found === undefined) {
      const [, , mixed, alpha] = dotsOf(1, (ctx) => {
        ctx.fillStyle = colour;
        ctx.fillRect(0, 0, 1, 1);
      });
      found = mixed | (alpha << 24);
      this._colours.set(colour, found);
    }
    return found;
  }

  /**
   * Straight lines with square ends, like those of a canvas.
   * @param {ArrayLike<number>} ends  x, y, x, y of each
   * @param {number} count
   * @param {number} width
   * @param {number} colour  of `colour`
   */
  lines(ends, count, width, colour) {
    for (let i = 0; i < 4 * count; i += 4) {
      const slanted = Math.abs(ends[i] - ends[i + 2]) > NEARLY && Math.abs(ends[i + 1] - ends[i + 3]) > NEARLY;
      if (slanted) this._slanted(ends, i, width, 0, colour);
      else this._box(ends, i, width, colour);
    }
  }

  /**
   * Filled triangles, of which one corner is a tip.
   * @param {ArrayLike<number>} ends  tip and middle of the opposite side: x, y, x, y of each
   * @param {number} slope  half of that side, for a height of 1
   * @param {number} colour  of `colour`
   */
  arrows(ends, slope, colour) {
    for (let i = 0; i < ends.length; i += 4) this._slanted(ends, i, 0, slope, colour);
  }

  // Numbers with fractions are read from `ends` where they are needed: as arguments each is an object of its own.

  /** @param {ArrayLike<number>} ends @param {number} i @param {number} width @param {number} colour */
  _box(ends, i, width, colour) {
    const { height, ratio, _pixels: pixels } = this;
    const x1 = ratio * ends[i];
    const y1 = ratio * ends[i + 1];
    const x2 = ratio * ends[i + 2];
    const y2 = ratio * ends[i + 3];
    const isUpright = Math.abs(x1 - x2) < Math.abs(y1 - y2);
    const half = (ratio * width) / 2;
    const rgb = colour & 0xffffff;
    // across the line, then along it
    const near = (isUpright ? x1 + x2 : y1 + y2) / 2 - half;
    const far = near + 2 * half;
    const begin = isUpright ? Math.min(y1, y2) : Math.min(x1, x2);
    const end = isUpright ? Math.max(y1, y2) : Math.max(x1, x2);
    const first = Math.max(Math.floor(begin), 0);
    const last = Math.min(Math.ceil(end), isUpright ? height : this.width) - 1;
    const stop = Math.min(Math.ceil(far), isUpright ? this.width : height);
    for (let i = Math.max(Math.floor(near), 0); i < stop; i++) {
      const share = (colour >>> 24) * ((i + 1 < far ? i + 1 : far) - (i > near ? i : near));
      const full = (share + 0.5) | 0;
      for (let j = first; j <= last; j++) {
        const at = isUpright ? placeOf(i, j, height) : placeOf(j, i, height);
        if (j > first && j < last) {
          if (pixels[at]) lay(pixels, at, rgb, full);
          else pixels[at] = rgb | (full << 24);
        } else {
          const part = (j + 1 < end ? j + 1 : end) - (j > begin ? j : begin);
          lay(pixels, at, rgb, (share * part + 0.5) | 0);
        }
      }
    }
  }

  /** @param {ArrayLike<number>} ends @param {number} i @param {number} thick @param {number} slope  by which it widens @param {number} colour */
  _slanted(ends, i, thick, slope, colour) {
    const { width, height, ratio, _pixels: pixels } = this;
    const x1 = ratio * ends[i];
    const y1 = ratio * ends[i + 1];
    const x2 = ratio * ends[i + 2];
    const y2 = ratio * ends[i + 3];
    const thin = (ratio * thick) / 2;
    const long = Math.hypot(x2 - x1, y2 - y1);
    const most = thin + slope * long;
    const ux = (x2 - x1) / long;
    const uy = (y2 - y1) / long;
    const wide = Math.abs(ux);
    const tall = Math.abs(uy);
    const large = Math.max(wide, tall);
    const small = Math.min(wide, tall);
    // how far a pixel reaches from its middle, along the line as well as across it
    const reach = (large + small) / 2;
    const below = Math.min(Math.max(y1, y2) + most, height);
    const right = Math.min(Math.max(x1, x2) + most, width);
    // where the middles of pixels are near enough to the line; a level one has no such place
    const spread = tall > LEVEL ? (most + reach) / tall : Infinity;
    const shift = tall > LEVEL ? ux / uy : 0;
    for (let y = Math.max(Math.floor(Math.min(y1, y2) - most), 0); y < below; y++) {
      const dy = y + 0.5 - y1;
      const middle = x1 - 0.5 + dy * shift;
      const end = Math.min(middle + spread, right);
      for (let x = Math.max(Math.ceil(middle - spread), Math.floor(Math.min(x1, x2) - most), 0); x < end; x++) {
        const dx = x + 0.5 - x1;
        const beside = dx * uy - dy * ux;
        const along = dx * ux + dy * uy;
        const half = thin + slope * along;
        if (Math.abs(beside) > half + reach) continue;
        const share = (inside(half - beside, large, small) + inside(half + beside, large, small) - 1) *
          (inside(along, large, small) + inside(long - along, large, small) - 1);
        if (share > 0) lay(pixels, placeOf(x, y, height), colour & 0xffffff, ((colour >>> 24) * share + 0.5) | 0);
      }
    }
  }

  /** A small image. @param {Int32Array} dots  of `dotsOf` @param {number} left @param {number} top */
  stamp(dots, left, top) {
    const { width, height, _pixels: pixels } = this;
    for (let k = 0; k < dots.length; k += 4) {
      const x = left + dots[k];
      const y = top + dots[k + 1];
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      lay(pixels, placeOf(x, y, height), dots[k + 2], dots[k + 3]);
    }
  }

  /**
   * Put the drawing, with what lies below, on a canvas in place of what was there before, and begin an empty one.
   * @param {CanvasRenderingContext2D} ctx
   * @param {import("./swept.js").Swept} swept  where is drawn, now and before
   */
  put(ctx, swept) {
    const { height, _pixels: pixels } = this;
    const half = pixels.length / 2;
    for (let i = 0; i < this._strips.length; i++) {
      const [top, bottom] = swept.rows(i);
      if (bottom <= top) continue;
      ctx.putImageData(this._strips[i], STRIP * i, 0, 0, top, STRIP, bottom - top);
      const first = STRIP * (height * i + top);
      pixels.copyWithin(first, half + first, half + STRIP * (height * i + bottom));
    }
  }
}

/**
 * What is drawn on a small square canvas: place, colour and alpha, x, y, colour, alpha, ...
 * @param {number} size
 * @param {(ctx: OffscreenCanvasRenderingContext2D) => void} draw
 */
export function dotsOf(size, draw) {
  const ctx = scratch(size, size);
  draw(ctx);
  const pixels = new Int32Array(ctx.getImageData(0, 0, size, size).data.buffer);
  const dots = [];
  for (let k = 0; k < pixels.length; k++) {
    if (pixels[k]) dots.push(k % size, Math.floor(k / size), pixels[k] & 0xffffff, pixels[k] >>> 24);
  }
  return Int32Array.from(dots);
}

/** @type {OffscreenCanvasRenderingContext2D|undefined} */
let spare;

/** A blank canvas of this size, to read from. @param {number} width @param {number} height */
function scratch(width, height) {
  spare ??= /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true }));
  Object.assign(spare.canvas, { width, height });
  return spare;
}

/** Where a pixel is. @param {number} x @param {number} y @param {number} height */
const placeOf = (x, y, height) => (((x >> SHIFT) * height + y) << SHIFT) | (x & 63);

/**
 * How much of a pixel is inside of a straight edge.
 * @param {number} depth  of its middle
 * @param {number} large @param {number} small  sizes of the edge's direction, to the right and down
 */
function inside(depth, large, small) {
  const far = Math.abs(depth);
  const left = (large + small) / 2 - far;
  let outside = 0;
  if (left > small) outside = 0.5 - far / large;
  else if (left > 0) outside = (left * left) / (2 * large * small);
  return depth < 0 ? outside : 1 - outside;
}

/** Lay a colour over a pixel; all are small integers, so that none becomes an object. @param {Int32Array} pixels @param {number} at @param {number} colour @param {number} alpha */
function lay(pixels, at, colour, alpha) {
  const under = pixels[at];
  if (!under || alpha > 254) {
    pixels[at] = colour | (alpha << 24);
    return;
  }
  if (under >> 24 === -1) {
    // over what has no holes: two of the colours at once, in 256 parts
    const part = alpha + (alpha >> 7);
    const left = 256 - part;
    const outer = (Math.imul(colour & 0xff00ff, part) + Math.imul(under & 0xff00ff, left) + 0x800080) >>> 8;
    const inner = Math.imul((colour >> 8) & 255, part) + Math.imul((under >> 8) & 255, left) + 128;
    pixels[at] = (outer & 0xff00ff) | (inner & 0xff00) | -0x1000000;
    return;
  }
  const rest = ((under >>> 24) * (255 - alpha)) / 255;
  const sum = alpha + rest;
  let mixed = (sum + 0.5) << 24;
  if (((under ^ colour) & 0xffffff) === 0) mixed |= colour;
  else if (alpha) {
    for (let k = 0; k < 24; k += 8) {
      mixed |= ((((colour >>> k) & 255) * alpha + ((under >>> k) & 255) * rest) / sum + 0.5) << k;
    }
  } else return;
  pixels[at] = mixed;
}
