/** What a drag moves, on a canvas of its own over the ground. */

import { drawsBySoftware, livelyLayer, ownLayers, show } from "./layers.js";
import { rehearsal } from "./rehearsal.js";
import { Sheet } from "./sheet.js";
import { Swept } from "./swept.js";

/**
 * @typedef {import("./batches.js").Batches} Batches
 * @typedef {import("./layers.js").Layer} Layer
 */

/** While more annotations than this move, those that move are hidden. */
const MOST_MOVING = 80;
/** Up to so many pixels lines and marks that move are drawn by hand: long lines are quicker by the browser. */
const MOST_BY_HAND = 80_000;

export class Moving {
  /** Draws by hand. @type {Sheet|null} */
  sheet = null;
  /** Whether the ground is another one than that under the sheet. */
  repainted = true;
  rehearse = () => {};
  /** Where the canvas was drawn on. */
  _swept = new Swept();
  /** @type {CanvasRenderingContext2D|null} */
  _unseen = null;

  /** @param {import("./renderer.js").Renderer} renderer @param {HTMLCanvasElement} canvas */
  constructor(renderer, canvas) {
    this.renderer = renderer;
    /** The canvas that is drawn on, one of `layers`. */
    this.layer = livelyLayer(canvas);
    this.layers = [this.layer];
    // the page is there first: to ask takes 30 ms
    setTimeout(() => {
      if (drawsBySoftware()) {
        this.sheet = new Sheet();
        this.layers = ownLayers(this.layer);
        [this.layer] = this.layers;
        renderer.viewChanged();
      }
      this.rehearse = rehearsal(() => this._drawUnseen());
      this.rehearse();
    }, 300);
  }

  /** @param {Batches|null} batches  null: nothing moves */
  paint(batches) {
    const { layers, _swept: swept } = this;
    if (batches) {
      const sheet = this._sheetFor(batches);
      const layer = layers[Number(sheet && batches.isPlain)];
      this._begin(swept);
      if (layer !== this.layer) swept.addAll();
      this.layer = layer;
      this._draw(layer.ctx, batches, sheet, swept);
    }
    // it is hidden when the ground is shown next; were it cleared now, what moved would be on neither meanwhile
    for (const layer of layers) show(layer, !!batches && layer === this.layer);
  }

  /** @param {Swept} swept */
  _begin(swept) {
    const { app: { view }, ratio } = this.renderer;
    swept.begin(view.width, view.height, ratio);
  }

  /** What draws these by hand, if that is quicker. @param {Batches} batches */
  _sheetFor(batches) {
    const { app: { view }, ratio } = this.renderer;
    return batches.byHand(view, ratio) < MOST_BY_HAND ? this.sheet : null;
  }

  /** Draw in place of what was there before. @param {CanvasRenderingContext2D} ctx @param {Batches} batches @param {Sheet|null} sheet @param {Swept} swept */
  _draw(ctx, batches, sheet, swept) {
    const { app: { view }, palette, annotations, ratio, ground: { canvas } } = this.renderer;
    const { movingCount } = annotations;
    let followed = movingCount && movingCount <= MOST_MOVING ? annotations.follow(ctx) : null;
    if (!sheet) {
      ctx.resetTransform();
      swept.clear(ctx);
    }
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (sheet) {
      sheet.begin(canvas.width, canvas.height, ratio);
      const below = batches.isPlain ? canvas : null;
      if (below !== sheet.below || (below && this.repainted)) {
        sheet.lay(below);
        this.repainted = false;
        swept.addAll();
      }
      batches.drawByHand(sheet, view, palette, swept);
      if (followed) {
        swept.addShown(followed);
        followed = annotations.drawByHand(sheet, palette, followed);
      }
      sheet.put(ctx, swept);
      batches.drawBelow(ctx, view, palette, swept);
    } else {
      batches.draw(ctx, view, palette, swept);
      if (followed) swept.addShown(followed);
    }
    if (followed) annotations.draw(ctx, palette, followed);
  }

  /** Two frames of a drag that moves everything by a little, off the screen. */
  _drawUnseen() {
    const { app: { store, view }, annotations, resting: batches, moves, pending } = this.renderer;
    if (!batches || moves.size || pending) return false;
    this._unseen ??= /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
    const { values } = store;
    const swept = new Swept();
    annotations.split({ has: () => true });
    try {
      for (const by of [0, 0.3]) {
        // numbers are no whole pixels in a drag, for which the browser compiles otherwise
        store.values = values.map((value) => value + by / view.scale);
        this._begin(swept);
        this._draw(this._unseen, batches, this._sheetFor(batches), swept);
      }
    } finally {
      store.values = values;
      annotations.split(moves);
    }
    return true;
  }
}
