/** Cubic splines by their poles: four make a Bezier curve, more a B-spline. */

import { line, spline } from "../geometry/curves.js";
import { coordinate, extras } from "./compose.js";
import { PointsTool } from "./points.js";

export class SplineTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "spline", title: "Spline", key: "j", group: "create", hint: "poles of a cubic spline, at least four",
    make: (app) => new SplineTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    // the number of poles is open: Enter or a right click ends it
    super(app, ["first pole: the start", "second pole", "third pole", ...Array(200).fill("next pole; Enter or a right click ends the spline")]);
  }

  doubleClick() {
    this.finish();
  }

  finish() {
    if (this.places.length >= 4) void this.commit();
    else if (this.places.length) this.app.say("a spline has at least four poles");
  }

  /** @param {import("../types.js").Place[]} places */
  compose(places) {
    const last = places[places.length - 1];
    return {
      text: `add_spline ${places.map((place) => coordinate(place.at)).join(" ")} noconnect`,
      extras: [...extras(places[0], "_.p1"), ...extras(last, "_.p2")],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const guides = points.slice(1).map((p, i) => line(points[i], p));
    return { points, guides, curves: points.length >= 4 ? [spline(points)] : [] };
  }
}
