/** Points. */

import { coordinate, extras } from "./compose.js";
import { PointsTool } from "./points.js";

export class PointTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "point", title: "Point", key: "p", group: "create", hint: "a point",
    make: (app) => new PointTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["place of the point"]);
  }

  /** @param {import("../types.js").Place[]} places */
  compose([p]) {
    return { text: `add_point ${coordinate(p.at)} noconnect`, extras: extras(p, "_") };
  }

  preview() {
    return { points: this.place ? [this.place.at] : [] };
  }
}
