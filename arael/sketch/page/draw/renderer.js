/**
 * Draws on three canvases: the ground (grid and what rests), what a drag moves, and the overlay. Only
 * what changed is drawn anew: by requestAnimationFrame, or at once the frame that answers the pointer.
 */

import { Annotations } from "./annotations.js";
import { drawGrid, drawScaleBar } from "./background.js";
import { Batches } from "./batches.js";
import { drawOverlay } from "./overlay.js";
import { readPalette } from "./palette.js";
import { Tint } from "./regions.js";

/** @typedef {import("../types.js").Point} Point */

/** @typedef {CanvasRenderingContext2D} Context */

/** Milliseconds after which a frame of a drag counts as late. */
const LATE = 60;
/** While more annotations than this move, those that move are hidden. */
const MOST_MOVING = 80;

/** Event: "painted" after a frame, for measurements. */
export class Renderer extends EventTarget {
  ratio = 1;
  /** Entities that the drag moves. @type {Set<string>} */
  moves = new Set();
  /** Name of the entity that owns each number. @type {string[]} */
  _owners = [];
  /** Which numbers the drag has moved already. */
  _seen = new Uint8Array(0);
  /** @type {Batches|null} */
  resting = null;
  /** @type {Batches|null} */
  _movingBatches = null;
  _dirty = { ground: true, moving: true, overlay: true };
  _request = 0;
  /** @type {Point|null} */
  _cursor = null;
  _late = 0;

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super();
    this.app = app;
    const canvas = (/** @type {string} */ id) => /** @type {HTMLCanvasElement} */ (app.root.querySelector(`#${id}`));
    this.ground = /** @type {Context} */ (canvas("ground").getContext("2d", { alpha: false }));
    this.moving = /** @type {Context} */ (canvas("moving").getContext("2d"));
    this.overlay = /** @type {Context} */ (canvas("overlay").getContext("2d"));
    this.annotations = new Annotations(app.store, app.view);
    this.tint = new Tint(app.store);
    this.palette = readPalette(app.canvas);
    new ResizeObserver(() => this.resize()).observe(app.canvas);
    new MutationObserver(() => this.themeChanged()).observe(document.documentElement, {
      attributes: true, attributeFilter: ["data-theme", "class"],
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.themeChanged());
  }

  /** The element has another size or the screen another pixel ratio. */
  resize() {
    const { canvas, view } = this.app;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    this.ratio = window.devicePixelRatio || 1;
    for (const { canvas: one } of [this.ground, this.moving, this.overlay]) {
      one.width = Math.round(width * this.ratio);
      one.height = Math.round(height * this.ratio);
    }
    view.resize(width, height);
  }

  themeChanged() {
    this.palette = readPalette(this.app.canvas);
    this.viewChanged();
  }

  viewChanged() {
    this._schedule({ ground: true, moving: true, overlay: true });
  }

  /** Records changed. @param {import("../store.js").ChangeDetail} _detail */
  changed(_detail) {
    this._owners = [];
    this._rest();
  }

  /** Verdict, selection or highlights changed. */
  restyled() {
    this.resting = this._movingBatches = null;
    this.viewChanged();
  }

  /** Only the overlay changed: hovering, previews. */
  overlayChanged() {
    this._schedule({ ground: false, moving: false, overlay: true });
  }

  /**
   * Numbers changed: those of a drag (offsets), or all.
   * @param {Uint32Array|null} offsets
   * @param {boolean} [now]  paint at once: one frame at most is under way, so that none waits behind
   *     another, and the next refresh of the screen has it
   */
  moved(offsets, now = false) {
    if (!offsets) {
      this._rest();
      return;
    }
    if (!offsets.length) return;
    if (!this._owners.length) this._owners = ownersOf(this.app.store);
    if (this._seen.length < this._owners.length) this._seen = new Uint8Array(this._owners.length);
    const before = this.moves.size;
    for (let i = 0; i < offsets.length; i++) {
      const offset = offsets[i];
      if (this._seen[offset]) continue;
      this._seen[offset] = 1;
      this.moves.add(this._owners[offset]);
    }
    const grown = this.moves.size > before;
    if (grown) this.resting = this._movingBatches = null;
    this._schedule({ ground: grown, moving: true, overlay: false }, now);
  }

  /** A frame of the drag is so many milliseconds late; 0: it is there. @param {number} delay */
  late(delay) {
    const late = delay > LATE ? delay : 0;
    if (late === this._late) return;
    this._late = late;
    this.overlayChanged();
  }

  /** Show the cursor of the commands. @param {Point|null} at */
  setCursor(at) {
    this._cursor = at;
    this.overlayChanged();
  }

  /** Nothing moves any more: all is drawn on the ground. */
  _rest() {
    this.moves.clear();
    this._seen.fill(0);
    this._late = 0;
    this.tint.changed();
    this.restyled();
  }

  /** @param {{ground: boolean, moving: boolean, overlay: boolean}} what @param {boolean} [now] */
  _schedule(what, now) {
    this._dirty.ground ||= what.ground;
    this._dirty.moving ||= what.moving;
    this._dirty.overlay ||= what.overlay;
    if (now) this.paint();
    else this._request ||= requestAnimationFrame(() => this.paint());
  }

  /** Whether something waits for the next refresh of the screen. */
  get pending() {
    return this._request !== 0;
  }

  /** How many entities the drag moves. */
  get movedCount() {
    return this.moves.size;
  }

  /** Draw what has changed. */
  paint() {
    cancelAnimationFrame(this._request);
    this._request = 0;
    const dirty = this._dirty;
    this._dirty = { ground: false, moving: false, overlay: false };
    if (dirty.ground) this._paintGround();
    if (dirty.moving) this._paintMoving();
    if (dirty.overlay) this._paintOverlay();
    this.dispatchEvent(new Event("painted"));
  }

  _paintOverlay() {
    this._ready(this.overlay);
    drawOverlay(this.overlay, this.app, this.palette, { cursor: this._cursor, late: this._late });
  }

  /** @param {Context} ctx */
  _ready(ctx) {
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
  }

  _paintGround() {
    const { app, palette, ground: ctx } = this;
    this._ready(ctx);
    ctx.fillStyle = palette.background;
    ctx.fillRect(0, 0, app.view.width, app.view.height);
    drawGrid(ctx, app.view, palette);
    if (app.shown.regions) this.tint.draw(ctx, app.view, palette, this.moves, false);
    this.resting ??= new Batches(app.store, (entity) => !this.moves.has(entity.name), app.shown);
    this.resting.draw(ctx, app.view, palette);
    const { annotations } = this;
    if (!this.moves.size || !annotations.fits) annotations.layout(ctx);
    if (this.moves.size) annotations.split(this.moves);
    annotations.draw(ctx, palette, annotations.still);
    drawScaleBar(ctx, app.view, palette, app.store.lengths);
  }

  _paintMoving() {
    const { app: { store, view, shown }, annotations, moving: ctx, moves, palette } = this;
    this._ready(ctx);
    ctx.clearRect(0, 0, view.width, view.height);
    if (!moves.size) return;
    if (shown.regions) this.tint.draw(ctx, view, palette, moves, true);
    this._movingBatches ??= new Batches(store, (entity) => moves.has(entity.name), shown);
    this._movingBatches.draw(ctx, view, palette);
    const { movingCount } = annotations;
    if (movingCount && movingCount <= MOST_MOVING) annotations.draw(ctx, palette, annotations.follow(ctx));
  }
}

/** @param {import("../store.js").Store} store */
function ownersOf(store) {
  /** @type {string[]} */
  const owners = [];
  for (const { name, at, size } of store.entities.values()) {
    for (let i = at; i < at + size; i++) owners[i] = name;
  }
  return owners;
}
