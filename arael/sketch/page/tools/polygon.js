/** Regular polygons: centre, a corner, and how many sides. */

import { circle, line } from "../geometry/curves.js";
import { dist, turned } from "../geometry/vectors.js";
import { coordinate, extras } from "./compose.js";
import { PointsTool } from "./points.js";

let sides = 6;

export class PolygonTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "polygon", title: "Polygon", key: "g", group: "create", hint: "centre and a corner; type the number of sides",
    make: (app) => new PolygonTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["centre of the polygon; type the number of sides", "a corner; type the number of sides"]);
  }

  fields() {
    return [this.field("sides", "sides", sides, "count")];
  }

  /** Enter after the number of sides only takes the number. */
  text() {
    this.stepDone();
  }

  get count() {
    const typed = Math.round(this.typed.number("sides", sides));
    return typed >= 3 && typed <= 200 ? typed : sides;
  }

  stepDone() {
    sides = this.count;
    this.typed.clear();
    this.app.renderer.overlayChanged();
  }

  /** @param {import("../types.js").Place[]} places */
  compose([m, p]) {
    sides = this.count;
    return {
      text: `add_polygon ${sides} ${coordinate(m.at)} ${coordinate(p.at)}`,
      extras: [...extras(m, `_${sides}.center`), ...extras(p, "_0.p1")],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const [m, p] = points;
    if (!p) return { points };
    const corners = Array.from({ length: this.count }, (_, i) => turned(p, m, (2 * Math.PI * i) / this.count));
    return { points, guides: [circle(m, dist(m, p))], curves: corners.map((q, i) => line(q, corners[(i + 1) % corners.length])) };
  }
}
