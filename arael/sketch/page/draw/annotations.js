/** Dimensions and glyphs of the visible part: laid out together, so that none overlaps another. */

import { boundsOfAll } from "../geometry/boxes.js";
import { curveOf, lineEnds, roughLength, sample } from "../geometry/curves.js";
import { splitHandle } from "../geometry/handles.js";
import { boxOfText } from "../geometry/lettering.js";
import { layoutDimension, measured } from "./dimensions.js";
import { drawGlyph, layoutGlyphs } from "./glyphs.js";
import { ARROW } from "./lines.js";
import { FONT } from "./palette.js";
import { Places } from "./places.js";
import { dimensionText } from "./texts.js";

/** What is shorter on the screen, in pixels, has no dimension shown. */
const SMALLEST = 18;
const MOST = 600;
const TEXT = `12px ${FONT}`;

/**
 * @typedef {import("./lines.js").Drawn} Drawn
 * @typedef {import("./glyphs.js").Glyph} Glyph
 */

export class Annotations {
  /** @param {import("../store.js").Store} store @param {import("../view.js").View} view */
  constructor(store, view) {
    this.store = store;
    this.view = view;
    /** @type {Drawn[]} */
    this.dimensions = [];
    /** @type {Glyph[]} */
    this.glyphs = [];
    /** @type {Places<string>} */
    this.places = new Places();
    /** A dimension whose text is being dragged, in place of its record. @type {import("../types.js").Dimension|null} */
    this.dragged = null;
    /** Glyphs that were dragged: by how many pixels. @type {Map<string, [number, number]>} */
    this.nudged = new Map();
    this.shown = { dimensions: true, glyphs: true };
    /** @type {Map<string, number>} */
    this._widths = new Map();
  }

  /** Lay out anew. @param {CanvasRenderingContext2D} ctx  measures texts */
  layout(ctx) {
    const { store, view } = this;
    this.places = new Places();
    this.dimensions = [];
    this.glyphs = [];
    const few = store.entities.size <= 400;
    if (few) this._takeCurves();
    const always = new Set([...store.selection, ...store.hovered, ...Object.keys(store.verdict.constraints)]);
    if (this.shown.dimensions && store.dimensions.size) this._layoutDimensions(ctx, always);
    if (this.shown.glyphs) this.glyphs = layoutGlyphs({ store, view, nudged: this.nudged }, this.places, always);
  }

  /** Move a glyph; it keeps its place beside its anchor. @param {string} name @param {[number, number]} by  pixels */
  nudge(name, by) {
    const [x, y] = this.nudged.get(name) ?? [0, 0];
    this.nudged.set(name, [x + by[0], y + by[1]]);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Set<string>} always */
  _layoutDimensions(ctx, always) {
    const { store, view } = this;
    const box = boundsOfAll(store);
    ctx.font = TEXT;
    const pen = {
      store, view, places: this.places,
      middle: /** @type {[number, number]} */ (box ? [(box.xmin + box.xmax) / 2, (box.ymin + box.ymax) / 2] : [0, 0]),
      width: (/** @type {string} */ text) => this._width(ctx, text),
    };
    for (const record of store.dimensions.values()) {
      const d = this.dragged?.name === record.name ? this.dragged : record;
      const wanted = always.has(d.name) || d === this.dragged;
      if (!wanted && (this.dimensions.length > MOST || !this._isLarge(d))) continue;
      const value = d.derived || store.dragging ? measured(store, d) : null;
      const drawn = layoutDimension(pen, d, dimensionText(d, store.unit, value));
      if (drawn) this.dimensions.push(drawn);
    }
  }

  /** Whether what a dimension measures is large enough and in sight. @param {import("../types.js").Dimension} d */
  _isLarge(d) {
    const { store, view } = this;
    const entity = store.entities.get(splitHandle(d.args[0])[0]);
    const curve = entity && curveOf(entity, store.values);
    if (!curve) return true;
    if (roughLength(curve) * view.scale < SMALLEST) return false;
    const [x, y] = view.toScreen(curve.type === "line" ? [curve.x1, curve.y1] : curve.type === "conic" ? [curve.cx, curve.cy] : curve.poles[0]);
    const reach = roughLength(curve) * view.scale + 200;
    return x > -reach && y > -reach && x < view.width + reach && y < view.height + reach;
  }

  /** @param {CanvasRenderingContext2D} ctx @param {string} text */
  _width(ctx, text) {
    let width = this._widths.get(text);
    if (width === undefined) {
      if (this._widths.size > 5000) this._widths.clear();
      width = ctx.measureText(text).width;
      this._widths.set(text, width);
    }
    return width;
  }

  /** Mark the curves themselves, so that texts and badges keep off them. */
  _takeCurves() {
    const { store, view, places } = this;
    for (const entity of store.entities.values()) {
      const curve = curveOf(entity, store.values);
      if (!curve) continue;
      const step = Math.max(12 / view.scale, roughLength(curve) / 150);
      for (const p of sample(curve, step)) {
        const [x, y] = view.toScreen(p);
        if (x > 0 && y > 0 && x < view.width && y < view.height) places.take(x, y, 3, 3);
      }
      if (entity.text && curve.type === "line") this._takeText(boxOfText(entity.text, ...lineEnds(curve)));
    }
  }

  /** Mark the box of a text: squares along its middle. @param {import("../types.js").Point[]} box */
  _takeText(box) {
    const { view, places } = this;
    const [a, b, , d] = box.map((p) => view.toScreen(p));
    const half = Math.hypot(d[0] - a[0], d[1] - a[1]) / 2;
    if (!half || 2 * half > view.height) return;
    const count = Math.min(Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / half / 2), 200);
    for (let i = 0; i < count; i++) {
      const [x, y] = [0, 1].map((k) => (a[k] + d[k]) / 2 + ((i + 0.5) / count) * (b[k] - a[k]));
      if (x > 0 && y > 0 && x < view.width && y < view.height) places.take(x, y, half, half);
    }
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {import("./palette.js").Palette} palette
   */
  draw(ctx, palette) {
    const colours = /** @type {Record<string, string>} */ (palette);
    const { store } = this;
    for (const drawn of this.dimensions) {
      const d = store.dimensions.get(drawn.name);
      const state = this._state(drawn.name);
      const quiet = d?.derived || d?.active === false;
      drawDimension(ctx, drawn, state ? colours[state] : quiet ? palette.derived : palette.dimension, palette.background);
    }
    for (const glyph of this.glyphs) {
      const look = {
        state: this._state(glyph.name),
        active: store.constraints.get(glyph.name)?.active !== false,
        hovered: store.hovered.has(glyph.name),
      };
      drawGlyph(ctx, glyph, look, palette);
    }
  }

  /** @param {string} name */
  _state(name) {
    const { store } = this;
    if (store.selection.has(name)) return "selected";
    const verdict = store.verdict.constraints[name];
    if (verdict === "impossible" || verdict === "redundant") return verdict;
    if (verdict === "here") return "redundant";
    return store.hovered.has(name) ? "preview" : "";
  }
}

/** Draws a dimension. @param {CanvasRenderingContext2D} ctx @param {Drawn} drawn @param {string} colour @param {string} back */
export function drawDimension(ctx, drawn, colour, back) {
  ctx.strokeStyle = ctx.fillStyle = colour;
  ctx.lineWidth = 0.8;
  ctx.globalAlpha = 0.6;
  ctx.beginPath();
  for (const [x1, y1, x2, y2] of drawn.thin) {
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
  }
  ctx.stroke();
  ctx.globalAlpha = 1;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (const [x1, y1, x2, y2] of drawn.lines) {
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
  }
  for (const [x, y, r, start, sweep] of drawn.arcs) {
    ctx.moveTo(x + r * Math.cos(start), y + r * Math.sin(start));
    ctx.arc(x, y, r, start, start + sweep, sweep < 0);
  }
  ctx.stroke();
  ctx.beginPath();
  for (const [x, y, ux, uy] of drawn.arrows) {
    const [bx, by, w] = [x - ARROW * ux, y - ARROW * uy, 0.28 * ARROW];
    ctx.moveTo(x, y);
    ctx.lineTo(bx - w * uy, by + w * ux);
    ctx.lineTo(bx + w * uy, by - w * ux);
    ctx.closePath();
  }
  ctx.fill();
  const { x, y, angle, text } = drawn.text;
  ctx.save();
  ctx.translate(x, y);
  ctx.rotate(angle);
  ctx.font = TEXT;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  // the background's colour around the digits keeps them readable where a line passes
  ctx.lineWidth = 3;
  ctx.lineJoin = "round";
  ctx.strokeStyle = back;
  ctx.strokeText(text, 0, 0.5);
  ctx.fillText(text, 0, 0.5);
  ctx.restore();
}
