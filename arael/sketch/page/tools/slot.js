/** Slots: two centres and a radius. */

import { arcAbout } from "../geometry/construct.js";
import { line } from "../geometry/curves.js";
import { add, dist, foot, left, sub, times, unit } from "../geometry/vectors.js";
import { coordinate, dimension, extras, short } from "./compose.js";
import { PointsTool } from "./points.js";

/** @typedef {import("../types.js").Point} Point */

export class SlotTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "slot", title: "Slot", key: "u", group: "create", hint: "two centres and the radius",
    make: (app) => new SlotTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["first centre of the slot", "second centre", "radius; type it"]);
  }

  /** @param {Point} p */
  radius(p) {
    const [a, b] = this.places.map((place) => place.at);
    return this.typed.number("radius", dist(p, foot(p, a, b)));
  }

  fields() {
    return this.places.length === 2 && this.place ? [this.field("radius", "radius", this.radius(this.place.at))] : [];
  }

  /** @param {import("../types.js").Place[]} places */
  compose([a, b, p]) {
    const radius = this.typed.number("radius", dist(p.at, foot(p.at, a.at, b.at)));
    if (!(radius > 0)) return null;
    return {
      text: `add_slot ${coordinate(a.at)} ${coordinate(b.at)} ${short(radius)}`,
      extras: [...extras(a, "_3.center"), ...extras(b, "_2.center"), ...dimension("radius", "_2", this.typed.text("radius"))],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const [a, b, p] = points;
    if (!b) return { points };
    if (!p) return { points, guides: [line(a, b)] };
    const n = times(left(unit(sub(b, a))), this.radius(p));
    const [a1, a2, b1, b2] = [add(a, n), sub(a, n), add(b, n), sub(b, n)];
    return { points: [a, b], guides: [line(a, b)], curves: [line(a1, b1), line(a2, b2), arcAbout(a, a1, a2), arcAbout(b, b2, b1)] };
  }
}
