/** Offset curves: of the selection or of one curve, on the side of the pointer, at a typed distance. */

import { CURVES, PicksTool } from "./picks.js";
import { curveOf, lineEnds, nearest, tangentAt } from "../geometry/curves.js";
import { add, cross, left, sub, times } from "../geometry/vectors.js";
import { short } from "./compose.js";

export class OffsetTool extends PicksTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "offset", title: "Offset", key: "n", group: "modify", hint: "a parallel copy at a distance",
    make: (app) => new OffsetTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, CURVES, 1);
    const selected = this.selected();
    if (selected.length) {
      this.names = selected;
      this.most = selected.length;
    }
  }

  get hint() {
    return this.picking ? "a curve to copy; double click takes the whole sequence" : "distance: click or type it";
  }

  get needsPlace() {
    return true;
  }

  /** Signed distance of the pointer: positive on the left. */
  get distance() {
    const { store } = this.app;
    if (!this.place || !this.names.length) return 0;
    const p = this.place.at;
    let best = { distance: Infinity, side: 1 };
    for (const name of this.names) {
      const entity = store.entities.get(name);
      const curve = entity && curveOf(entity, store.values);
      if (!curve) continue;
      const foot = nearest(curve, p);
      if (foot.distance < best.distance) {
        best = { distance: foot.distance, side: cross(tangentAt(curve, foot.t), sub(p, foot.at)) < 0 ? -1 : 1 };
      }
    }
    return best.distance * best.side;
  }

  fields() {
    if (this.picking) return [];
    const value = this.typed.number("distance", Math.abs(this.distance));
    return [{ id: "distance", title: "distance", text: this.typed.text("distance"), value, quantity: /** @type {const} */ ("length") }];
  }

  compose() {
    const value = this.typed.word("distance") || short(Math.abs(this.distance));
    const side = this.distance < 0 ? "right" : "left";
    const lines = this.names.length === 1 && this.app.store.entities.get(this.names[0])?.kind === "line";
    if (lines) return { text: `offset_line ${this.names[0]} ${value}${side === "right" ? " right" : ""}`, extras: [] };
    return { text: `offset ${this.names.join(" ")} ${value} ${side}`, extras: [] };
  }

  cancel() {
    super.cancel();
    this.most = 1;
  }

  preview() {
    const { store } = this.app;
    const d = Math.sign(this.distance) * this.typed.number("distance", Math.abs(this.distance));
    /** @type {import("../types.js").Curve[]} */
    const curves = [];
    for (const name of this.names) {
      const entity = store.entities.get(name);
      const curve = entity && curveOf(entity, store.values);
      if (curve?.type === "line") {
        const n = times(left(tangentAt(curve, 0)), d);
        const [a, b] = lineEnds(curve).map((p) => add(p, n));
        curves.push({ type: "line", x1: a[0], y1: a[1], x2: b[0], y2: b[1] });
      } else if (curve?.type === "conic" && curve.rx === curve.ry && curve.rx - d > 0) {
        curves.push({ ...curve, rx: curve.rx - d, ry: curve.ry - d });
      }
    }
    return { names: this.names, curves: this.picking ? [] : curves };
  }
}
