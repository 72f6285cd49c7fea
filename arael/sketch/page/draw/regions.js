/** Closed regions as a tint, open ends as dotted circles. */

import { regionsOf } from "../geometry/regions.js";
import { pointAt, roughLength } from "../geometry/curves.js";
import { polyline } from "./paths.js";

/** While more entities than this are drawn, a drag leaves regions out that it moves. */
const MOST_MOVING = 200;

/** The regions of a drawing, found anew when it was asked for after a change. */
export class Tint {
  /** @type {import("../geometry/regions.js").Regions|null} */
  _found = null;

  /** @param {import("../store.js").Store} store */
  constructor(store) {
    this.store = store;
  }

  /** Geometry has changed. */
  changed() {
    this._found = null;
  }

  get found() {
    this._found ??= regionsOf(this.store);
    return this._found;
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {import("../view.js").View} view
   * @param {import("./palette.js").Palette} palette
   * @param {{has: (name: string) => boolean}} moved  names
   * @param {boolean} moving  whether to draw what they bound, or the rest
   */
  draw(ctx, view, palette, moved, moving) {
    if (moving && this.store.entities.size > MOST_MOVING) return;
    if (moving) this.changed();
    const { loops, openEnds } = this.found;
    ctx.fillStyle = palette.preview;
    ctx.globalAlpha = 0.08;
    ctx.beginPath();
    for (const { names, parts } of loops) {
      if (names.some((name) => moved.has(name)) !== moving) continue;
      polyline(ctx, outline(parts, view), true);
    }
    ctx.fill("evenodd");
    ctx.globalAlpha = 1;
    if (moving) return;
    ctx.strokeStyle = palette.note;
    ctx.lineWidth = 1.2;
    ctx.setLineDash([2, 2.5]);
    for (const end of openEnds) {
      const [x, y] = view.toScreen(end);
      ctx.beginPath();
      ctx.arc(x, y, 7, 0, 2 * Math.PI);
      ctx.stroke();
    }
    ctx.setLineDash([]);
  }
}

/** Pixels along a loop. @param {import("../geometry/regions.js").Loop["parts"]} parts @param {import("../view.js").View} view */
function outline(parts, view) {
  return parts.flatMap(({ curve, from, to }) => {
    const pixels = view.scale * roughLength(curve) * Math.abs(to - from);
    const count = curve.type === "line" ? 1 : Math.min(Math.max(Math.ceil(pixels / 4), 8), 2000);
    return Array.from({ length: count + 1 }, (_, i) => view.toScreen(pointAt(curve, from + (i / count) * (to - from))));
  });
}
