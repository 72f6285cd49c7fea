/**
 * Draws on three canvases: the ground (grid and what rests), what a drag moves, and the overlay. Only
 * what changed is drawn anew: by requestAnimationFrame, or at once the frame that answers the pointer.
 */

import { Annotations } from "./annotations.js";
import { drawGrid, drawScaleBar } from "./background.js";
import { Batches } from "./batches.js";
import { drawsBySoftware, livelyLayer, ownLayer, show, stillLayer } from "./layers.js";
import { drawOverlay, hasOverlay } from "./overlay.js";
import { readPalette } from "./palette.js";
import { rehearsal } from "./rehearsal.js";
import { Sheet } from "./sheet.js";
import { Swept } from "./swept.js";

/** @typedef {import("../types.js").Point} Point */

/** While more annotations than this move, those that move are hidden. */
const MOST_MOVING = 80;
/** Up to so many pixels lines and marks that move are drawn by hand: long lines are quicker by the browser. */
const MOST_BY_HAND = 80_000;
/** Milliseconds after which a frame of a drag counts as late. */
const LATE = 60;

/** Event: "painted" after a frame, for measurements. */
export class Renderer extends EventTarget {
  /** @param {import("../app.js").App} app */
  constructor(app) {
    super();
    this.app = app;
    const canvas = (/** @type {string} */ id) => /** @type {HTMLCanvasElement} */ (app.root.querySelector(`#${id}`));
    this.ground = stillLayer(canvas("ground"));
    this.moving = livelyLayer(canvas("moving"));
    this.overlay = livelyLayer(canvas("overlay"));
    this.annotations = new Annotations(app.store, app.view);
    this.palette = readPalette(app.canvas);
    this.ratio = 1;
    /** Entities that the drag moves. @type {Set<string>} */
    this._moved = new Set();
    /** Name of the entity that owns each number. @type {string[]} */
    this._owners = [];
    /** Which numbers the drag has moved already. */
    this._seen = new Uint8Array(0);
    /** @type {Batches|null} */
    this._resting = null;
    /** @type {Batches|null} */
    this._movingBatches = null;
    /** Where the canvas of what moves was drawn on. */
    this._swept = new Swept();
    /** Draws what moves by hand. @type {Sheet|null} */
    this._sheet = null;
    /** @type {CanvasRenderingContext2D|null} */
    this._unseen = null;
    this._rehearse = () => {};
    // the page is there first: to ask takes 30 ms
    setTimeout(() => {
      if (drawsBySoftware()) {
        this._sheet = new Sheet();
        this.moving = ownLayer(this.moving);
        this.viewChanged();
      }
      this._rehearse = rehearsal(() => this._drawUnseen());
      this._rehearse();
    }, 300);
    this._dirty = { ground: true, moving: true, overlay: true };
    this._request = 0;
    /** @type {Point|null} */
    this._cursor = null;
    this._late = 0;
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
    for (const layer of [this.ground, this.moving, this.overlay]) {
      layer.resize(Math.round(width * this.ratio), Math.round(height * this.ratio));
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
    this._resting = this._movingBatches = null;
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
    const before = this._moved.size;
    for (let i = 0; i < offsets.length; i++) {
      const offset = offsets[i];
      if (this._seen[offset]) continue;
      this._seen[offset] = 1;
      this._moved.add(this._owners[offset]);
    }
    const grown = this._moved.size > before;
    if (grown) this._resting = this._movingBatches = null;
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
    this._moved.clear();
    this._seen.fill(0);
    this._late = 0;
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
    return this._moved.size;
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
    const { app, palette } = this;
    const { ctx } = this.overlay;
    const state = { cursor: this._cursor, late: this._late };
    this._ready(ctx);
    drawOverlay(ctx, app, palette, state);
    show(this.overlay, hasOverlay(app, state));
  }

  /** @param {CanvasRenderingContext2D} ctx */
  _ready(ctx) {
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
  }

  _paintGround() {
    const { app, palette } = this;
    const { ctx } = this.ground;
    this._ready(ctx);
    ctx.fillStyle = palette.background;
    ctx.fillRect(0, 0, app.view.width, app.view.height);
    drawGrid(ctx, app.view, palette);
    this._resting ??= new Batches(app.store, (entity) => !this._moved.has(entity.name), app.shown);
    this._resting.draw(ctx, app.view, palette);
    const { annotations } = this;
    if (!this._moved.size || !annotations.fits) annotations.layout(ctx);
    if (this._moved.size) annotations.split(this._moved);
    annotations.draw(ctx, palette, annotations.still);
    drawScaleBar(ctx, app.view, palette, app.store.unit);
    this.ground.done();
    this._rehearse();
  }

  _paintMoving() {
    const { app: { store, view, shown }, _swept: swept } = this;
    const moves = this._moved.size > 0;
    show(this.moving, moves);
    // it is hidden when the ground is shown next; were it cleared now, what moved would be on neither meanwhile
    if (!moves) return;
    swept.begin(view.width, view.height, this.ratio);
    this._movingBatches ??= new Batches(store, (entity) => this._moved.has(entity.name), shown);
    this._drawMoving(this.moving.ctx, this._movingBatches, swept);
  }

  /** Draw in place of what was there before. @param {CanvasRenderingContext2D} ctx @param {Batches} batches @param {Swept} swept */
  _drawMoving(ctx, batches, swept) {
    const { app: { view }, palette, annotations, ratio, moving: { canvas } } = this;
    const { movingCount } = annotations;
    let followed = movingCount && movingCount <= MOST_MOVING ? annotations.follow(ctx) : null;
    const sheet = batches.byHand(view, ratio) < MOST_BY_HAND ? this._sheet : null;
    if (sheet) {
      this._ready(ctx);
      sheet.begin(canvas.width, canvas.height, ratio);
      batches.drawByHand(sheet, view, palette, swept);
      if (followed) {
        swept.addShown(followed);
        followed = annotations.drawByHand(sheet, palette, followed);
      }
      sheet.put(ctx, swept);
      batches.drawBelow(ctx, view, palette, swept);
    } else {
      ctx.resetTransform();
      swept.clear(ctx);
      this._ready(ctx);
      batches.draw(ctx, view, palette, swept);
      if (followed) swept.addShown(followed);
    }
    if (followed) annotations.draw(ctx, palette, followed);
  }

  /** Two frames of a drag that moves everything by a little, off the screen. */
  _drawUnseen() {
    const { app: { store, view }, annotations, _resting: batches } = this;
    if (!batches || this._moved.size || this._request) return false;
    this._unseen ??= /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
    const { values } = store;
    const swept = new Swept();
    annotations.split({ has: () => true });
    try {
      for (const by of [0, 0.3]) {
        // numbers are no whole pixels in a drag, for which the browser compiles otherwise
        store.values = values.map((value) => value + by / view.scale);
        swept.begin(view.width, view.height, this.ratio);
        this._drawMoving(this._unseen, batches, swept);
      }
    } finally {
      store.values = values;
      annotations.split(this._moved);
    }
    return true;
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
