/** Dimensions and glyphs of the visible part: laid out together, so that none overlaps another. */

import { boundsOfAll } from "../geometry/boxes.js";
import { curveOf, roughLength } from "../geometry/curves.js";
import { splitHandle } from "../geometry/handles.js";
import { drawDimensions, TEXT } from "./dimension_marks.js";
import { layoutDimension, measured } from "./dimensions.js";
import { Follower } from "./follower.js";
import { constraintsOf, drawGlyph, layoutGlyphs } from "./glyphs.js";
import { takeCurves } from "./obstacles.js";
import { EDGES } from "./palette.js";
import { Places, SamePlaces } from "./places.js";
import { dimensionText } from "./texts.js";

/** What is shorter on the screen, in pixels, has no dimension shown. */
const SMALLEST = 18;
const MOST = 600;

/**
 * @typedef {import("./lines.js").Drawn} Drawn
 * @typedef {import("./glyphs.js").Glyph} Glyph
 * @typedef {import("./palette.js").Palette} Palette
 * @typedef {import("../types.js").Dimension} Dimension
 * @typedef {import("../types.js").Constraint} Constraint
 * @typedef {{dimensions: Drawn[], glyphs: Glyph[]}} Shown
 */

export class Annotations {
  /** @type {Drawn[]} */
  dimensions = [];
  /** @type {Glyph[]} */
  glyphs = [];
  /** @type {Places<string>} */
  places = new Places();
  /** A dimension whose text is being dragged, in place of its record. @type {import("../types.js").Dimension|null} */
  dragged = null;
  /** Glyphs that were dragged: by how many pixels. @type {Map<string, [number, number]>} */
  nudged = new Map();
  /** Of the badges all, or those of what is selected, hovered or part of a conflict. */
  shown = { dimensions: true, glyphs: false };
  /** What a drag leaves where it is. @type {Shown} */
  still = { dimensions: [], glyphs: [] };
  /** What is shown and moves in a drag. @type {{dimensions: Follower[], constraints: Constraint[], always: Set<string>}} */
  _moving = { dimensions: [], constraints: [], always: new Set() };
  /** Where each was laid out among its possible places. @type {Map<string, number>} */
  _choices = new Map();
  /** Middle of the drawing when it was laid out. @type {import("../types.js").Point} */
  _middle = [0, 0];
  /** The view for which it was laid out. */
  _for = "";
  /** @type {Map<string, number>} */
  _widths = new Map();

  /** @param {import("../store.js").Store} store @param {import("../view.js").View} view */
  constructor(store, view) {
    this.store = store;
    this.view = view;
  }

  /** Whether it was laid out for the view as it is. */
  get fits() {
    return this._for === viewKey(this.view);
  }

  /** Lay out anew. @param {CanvasRenderingContext2D} ctx  measures texts */
  layout(ctx) {
    const { store, view } = this;
    this._for = viewKey(view);
    this.places = new Places();
    this.dimensions = [];
    const always = new Set([...store.selection, ...store.hovered, ...Object.keys(store.verdict.constraints)]);
    const constraints = this.shown.glyphs ? store.constraints.values() : constraintsOf(store, store.selection);
    takeCurves(store, view, this.places);
    if (this.shown.dimensions && store.dimensions.size) this._layoutDimensions(ctx, always);
    this.glyphs = layoutGlyphs(this._scene, this.places, always, constraints, this._choices);
    this.still = this;
    this._moving = { dimensions: [], constraints: [], always: new Set() };
  }

  get _scene() {
    return { store: this.store, view: this.view, nudged: this.nudged };
  }

  /** Badges of what is hovered, beside those that are laid out. @returns {Glyph[]} */
  hoveredGlyphs() {
    const { store, places } = this;
    if (this.shown.glyphs || !this.fits || !store.hovered.size) return [];
    const there = new Set(this.glyphs.map((one) => one.name));
    const found = layoutGlyphs(this._scene, new Places(places), store.hovered, constraintsOf(store, store.hovered));
    return found.filter((one) => !there.has(one.name));
  }

  /**
   * How far dimensions reach beyond a rectangle of the sketch, in pixels; they are laid out for the view as it is.
   * @param {CanvasRenderingContext2D} ctx @param {import("../view.js").Box} box
   * @returns {import("../view.js").Margins}
   */
  reach(ctx, box) {
    if (!this.fits) this.layout(ctx);
    const [x1, y1] = this.view.toScreen([box.xmin, box.ymax]);
    const [x2, y2] = this.view.toScreen([box.xmax, box.ymin]);
    const xs = [x1, x2];
    const ys = [y1, y2];
    for (const { lines, thin, arcs, text, half } of this.dimensions) {
      for (const [i, one] of [...lines, ...thin].entries()) (i % 2 ? ys : xs).push(one);
      for (const [x, y, r] of arcs) {
        xs.push(x - r, x + r);
        ys.push(y - r, y + r);
      }
      const [w, h] = [Math.abs(Math.cos(text.angle)), Math.abs(Math.sin(text.angle))];
      xs.push(text.x - w * half - 8 * h, text.x + w * half + 8 * h);
      ys.push(text.y - h * half - 8 * w, text.y + h * half + 8 * w);
    }
    return {
      left: x1 - Math.min(...xs), right: Math.max(...xs) - x2, top: y1 - Math.min(...ys), bottom: Math.max(...ys) - y2,
    };
  }

  /** Part what is shown into what a drag of these entities moves, and what it does not. @param {Pick<ReadonlySet<string>, "has">} moved */
  split(moved) {
    const { store } = this;
    const moves = (/** @type {{args: string[]}|undefined} */ one) => !!one?.args.some((arg) => moved.has(splitHandle(arg)[0]));
    const dimensions = this.dimensions.map((one) => store.dimensions.get(one.name)).filter((one) => one !== undefined);
    // the ring of a coincidence is seen where something is to be said about it only
    const drawn = this.glyphs.filter((one) => !one.ring || this._state(one.name));
    const always = new Set(drawn.filter((one) => one.name === one.of).map((one) => one.name));
    const constraints = [...new Set(drawn.map((one) => one.of))].map((name) => store.constraints.get(name)).filter((one) => one !== undefined);
    const followers = dimensions.filter(moves).map((one) => new Follower(store, one));
    this._moving = { dimensions: followers, constraints: constraints.filter(moves), always };
    this.still = {
      dimensions: this.dimensions.filter((one) => !moves(store.dimensions.get(one.name))),
      glyphs: this.glyphs.filter((one) => !moves(store.constraints.get(one.of))),
    };
  }

  /** How many of those that are shown move. */
  get movingCount() {
    return this._moving.dimensions.length + this._moving.constraints.length;
  }

  /**
   * What moves, where it is now; on the side and level on which it was laid out.
   * @param {CanvasRenderingContext2D} ctx
   * @returns {Shown}
   */
  follow(ctx) {
    const { view } = this;
    const { dimensions, constraints, always } = this._moving;
    const places = new SamePlaces(this._choices);
    const pen = this._pen(ctx, places);
    const drawn = dimensions.map((one) => one.drawn(view.scale, () => this._layoutDimension(pen, one.record)))
      .filter((one) => one !== null);
    return { dimensions: drawn, glyphs: layoutGlyphs(this._scene, places, always, constraints) };
  }

  /** Move a glyph; it keeps its place beside its anchor. @param {string} name @param {[number, number]} by  pixels */
  nudge(name, by) {
    const [x, y] = this.nudged.get(name) ?? [0, 0];
    this.nudged.set(name, [x + by[0], y + by[1]]);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Set<string>} always */
  _layoutDimensions(ctx, always) {
    const { store } = this;
    const box = boundsOfAll(store);
    this._middle = box ? [(box.xmin + box.xmax) / 2, (box.ymin + box.ymax) / 2] : [0, 0];
    const pen = this._pen(ctx, this.places);
    // leaders and notes have more room to give way than lines that stand beside what they measure
    const all = [...store.dimensions.values()];
    for (const record of [...all.filter(isLinear), ...all.filter((one) => !isLinear(one))]) {
      const d = this.dragged?.name === record.name ? this.dragged : record;
      const wanted = always.has(d.name) || d === this.dragged;
      if (!wanted && (this.dimensions.length > MOST || !this._isLarge(d))) continue;
      const drawn = this._layoutDimension(pen, d);
      if (drawn) this.dimensions.push(drawn);
    }
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Places<string>} places @returns {import("./lines.js").Pen} */
  _pen(ctx, places) {
    const { store, view, _middle: middle } = this;
    ctx.font = TEXT;
    return { store, view, places, middle, width: (text) => this._width(ctx, text) };
  }

  /** @param {import("./lines.js").Pen} pen @param {Dimension} d */
  _layoutDimension(pen, d) {
    const { store } = this;
    const value = d.derived || store.dragging ? measured(store, d) : null;
    pen.places.choosing(d.name);
    const drawn = layoutDimension(pen, d, dimensionText(d, store.lengths, value));
    if (pen.places === this.places) this._choices.set(d.name, this.places.refused);
    return drawn;
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

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {Palette} palette
   * @param {Shown} shown
   */
  draw(ctx, palette, shown) {
    for (const { colour, dash, all } of this._byLook(palette, shown.dimensions)) {
      drawDimensions(ctx, all, colour, palette.background, dash);
    }
    this.drawGlyphs(ctx, palette, shown.glyphs);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Palette} palette @param {Glyph[]} glyphs */
  drawGlyphs(ctx, palette, glyphs) {
    const { store } = this;
    for (const glyph of glyphs) {
      const look = {
        state: this._state(glyph.name),
        active: store.constraints.get(glyph.of)?.active !== false,
        hovered: store.hovered.has(glyph.name),
      };
      drawGlyph(ctx, glyph, look, palette);
    }
  }

  /** Dimensions that look alike. @param {Palette} palette @param {Drawn[]} dimensions */
  _byLook(palette, dimensions) {
    const colours = /** @type {Record<string, string>} */ (palette);
    /** @type {Map<string, {colour: string, dash: number[], all: Drawn[]}>} */
    const byLook = new Map();
    for (const drawn of dimensions) {
      const d = this.store.dimensions.get(drawn.name);
      const state = this._state(drawn.name);
      const quiet = d?.derived || d?.active === false;
      const colour = state ? colours[state] : quiet ? palette.derived : palette.dimension;
      const dash = EDGES[state] ?? [];
      const look = `${colour} ${dash}`;
      const same = byLook.get(look);
      if (same) same.all.push(drawn);
      else byLook.set(look, { colour, dash, all: [drawn] });
    }
    return byLook.values();
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

const LINEAR = new Set(["length", "distance", "hdistance", "vdistance"]);

/** @param {Dimension} one */
const isLinear = (one) => LINEAR.has(one.kind);

/** @param {import("../view.js").View} view */
const viewKey = ({ x, y, scale, width, height }) => [x, y, scale, width, height].join(" ");
