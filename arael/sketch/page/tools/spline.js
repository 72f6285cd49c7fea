/** Cubic splines by their poles, of which four make a Bezier curve and more a B-spline, or through points. */

import { line, spline } from "../geometry/curves.js";
import { piecesThrough } from "../geometry/splines.js";
import { coordinate, extras } from "./compose.js";
import { PointsTool } from "./points.js";

export class SplineTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "spline", title: "Spline", key: "j", group: "create", hint: "poles of a cubic spline, at least four",
    make: (app) => new SplineTool(app),
  };

  least = 4;
  /** What its places are, at the end of the command. */
  words = "noconnect";
  refusal = "a spline has at least four poles";

  /** @param {import("../app.js").App} app @param {string[]} [first] @param {string} [next] */
  constructor(app, first = ["first pole: the start", "second pole", "third pole"], next = "next pole") {
    // the number of places is open: Enter or a right click ends it
    super(app, [...first, ...Array(200).fill(`${next}; Enter or a right click ends the spline`)]);
  }

  doubleClick() {
    this.finish();
  }

  finish() {
    if (this.places.length >= this.least) void this.commit();
    else if (this.places.length) this.app.say(this.refusal);
  }

  /** @param {import("../types.js").Place[]} places */
  compose(places) {
    const last = places[places.length - 1];
    return {
      text: `add_spline ${places.map((place) => coordinate(place.at)).join(" ")} ${this.words}`,
      extras: [...extras(places[0], "_.p1"), ...extras(last, "_.p2")],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const guides = points.slice(1).map((p, i) => line(points[i], p));
    return { points, guides, curves: points.length >= 4 ? [spline(points)] : [] };
  }
}

/** A spline through points. */
export class ThroughTool extends SplineTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "spline_through", title: "Spline through points", key: "", group: "create",
    hint: "points that a cubic spline goes through, at least three", make: (app) => new ThroughTool(app),
  };

  least = 3;
  words = "through noconnect";
  refusal = "a spline goes through at least three points";

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["first point: the start", "second point"], "next point");
  }

  preview() {
    const points = this.all.map((place) => place.at);
    /** @type {import("../types.js").Spline[]} */
    const curves = points.length >= 2 ? [{ type: "spline", poles: points, pieces: piecesThrough(points) }] : [];
    return { points, guides: [], curves };
  }
}
