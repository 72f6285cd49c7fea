/** Circles: by centre, by two or three points, tangent to two or three lines. */

import { circle, curveOf, line, lineEnds } from "../geometry/curves.js";
import { circleThrough, circleTouching, incircle } from "../geometry/construct.js";
import { add, dist, mix, sub, times, unit } from "../geometry/vectors.js";
import { coordinate, dimension, extras, short } from "./compose.js";
import { PointsTool, movedTo } from "./points.js";
import { PicksTool } from "./picks.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../app.js").App} App
 */

class CentreCircle extends PointsTool {
  /** @param {App} app */
  constructor(app) {
    super(app, ["centre of the circle", "a point of the circle; type the radius"]);
  }

  fields() {
    const [c] = this.places;
    return c && this.place ? [this.field("radius", "radius", dist(c.at, this.adjusted(this.place).at))] : [];
  }

  /** @param {Place} place */
  adjusted(place) {
    const c = this.places[0]?.at;
    if (!c || !this.typed.any) return place;
    return movedTo(place, add(c, times(unit(sub(place.at, c)), this.typed.number("radius", dist(c, place.at)))));
  }

  /** @param {Place[]} places */
  compose([c, p]) {
    // a point that lies on the circle: an endpoint or middle that was snapped to
    const [handle] = p.snap?.handles ?? [];
    const on = handle && !p.bare && (p.snap?.kind === "endpoint" || p.snap?.kind === "centre") ? [`point_on ${handle} _`] : [];
    return {
      text: `add_circle ${coordinate(c.at)} ${short(dist(c.at, p.at))} noconnect`,
      extras: [...extras(c, "_.center"), ...on, ...dimension("radius", "_", this.typed.text("radius"))],
    };
  }

  preview() {
    const [c, p] = this.all.map((place) => place.at);
    return { curves: p ? [circle(c, dist(c, p))] : [], points: c ? [c] : [], guides: p ? [line(c, p)] : [] };
  }
}

class RimCircle extends PointsTool {
  /** @param {App} app @param {2|3} count */
  constructor(app, count) {
    super(app, ["a point of the circle", count === 2 ? "the opposite point; type the diameter" : "a second point", "a third point"].slice(0, count));
    this.count = count;
  }

  fields() {
    const [a] = this.places;
    return this.count === 2 && a && this.place ? [this.field("diameter", "diameter", dist(a.at, this.adjusted(this.place).at))] : [];
  }

  /** @param {Place} place */
  adjusted(place) {
    const a = this.places[0]?.at;
    if (!a || !this.typed.any || this.count !== 2) return place;
    return movedTo(place, add(a, times(unit(sub(place.at, a)), this.typed.number("diameter", dist(a, place.at)))));
  }

  /** @param {Place[]} places */
  compose(places) {
    const on = places.flatMap((place) => {
      const [handle] = place.snap?.handles ?? [];
      return handle && !place.bare && ["endpoint", "centre"].includes(place.snap?.kind ?? "") ? [`point_on ${handle} _`] : [];
    });
    return {
      text: `add_circle${this.count} ${places.map((place) => coordinate(place.at)).join(" ")} noconnect`,
      extras: [...on, ...dimension("diameter", "_", this.typed.text("diameter"))],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const [a, b, c] = points;
    if (this.count === 2 && b) return { curves: [circle(mix(a, b, 0.5), dist(a, b) / 2)], points };
    const found = c ? circleThrough(a, b, c) : null;
    return { curves: found ? [found] : [], points, guides: !c && b ? [line(a, b)] : [] };
  }
}

class TangentCircle extends PicksTool {
  /** @param {App} app @param {2|3} count */
  constructor(app, count) {
    super(app, ["line"], count);
    this.count = count;
  }

  get hint() {
    if (this.names.length < this.count) return `line ${this.names.length + 1} of ${this.count} that the circle touches`;
    return "radius: click or type it";
  }

  get needsPlace() {
    return this.count === 2;
  }

  /** @returns {[Point, Point][]} */
  get lines() {
    return this.names.flatMap((name) => {
      const entity = this.app.store.entities.get(name);
      const curve = entity && curveOf(entity, this.app.store.values);
      return curve?.type === "line" ? [lineEnds(curve)] : [];
    });
  }

  /** Radius at the pointer: of the circle that touches both lines and is nearest to it. */
  get radius() {
    const [a, b] = this.lines;
    if (!this.place || !b) return 0;
    const p = this.place.at;
    return Math.min(...[a, b].map(([q, r]) => distanceToLine(p, q, r)));
  }

  fields() {
    if (this.count === 3 || this.names.length < 2) return [];
    const value = this.typed.number("radius", this.radius);
    return [{ id: "radius", title: "radius", text: this.typed.text("radius"), value, quantity: /** @type {const} */ ("length") }];
  }

  compose() {
    const names = this.names.join(" ");
    if (this.count === 3) return { text: `add_circle3t ${names} noconnect`, extras: [] };
    const typed = this.typed.text("radius");
    const radius = this.typed.number("radius", this.radius);
    return { text: `add_circle2t ${names} ${short(radius)} noconnect`, extras: dimension("radius", "_", typed) };
  }

  preview() {
    const { lines } = this;
    const found =
      this.count === 3 && lines.length === 3
        ? incircle(lines)
        : this.count === 2 && lines.length === 2 && this.place
          ? circleTouching(lines[0], lines[1], this.place.at, this.typed.number("radius", this.radius))
          : null;
    return { names: this.names, curves: found ? [found] : [] };
  }
}

/** @param {Point} p @param {Point} a @param {Point} b */
function distanceToLine(p, a, b) {
  const d = unit(sub(b, a));
  const v = sub(p, a);
  return Math.abs(d[0] * v[1] - d[1] * v[0]);
}

/** @type {import("../types.js").ToolSpec[]} */
export const CIRCLES = [
  { id: "circle", title: "Circle", key: "o", group: "create", hint: "by centre and radius", make: (app) => new CentreCircle(app) },
  { id: "circle2", title: "Circle by two points", key: "Shift+O", group: "create", hint: "by the ends of a diameter", make: (app) => new RimCircle(app, 2) },
  { id: "circle3", title: "Circle by three points", key: "Shift+I", group: "create", hint: "through three points", make: (app) => new RimCircle(app, 3) },
  { id: "circle2t", title: "Circle tangent to two lines", key: "Shift+T", group: "create", hint: "two lines, then the radius", make: (app) => new TangentCircle(app, 2) },
  { id: "circle3t", title: "Circle tangent to three lines", key: "Shift+Y", group: "create", hint: "three lines", make: (app) => new TangentCircle(app, 3) },
];
