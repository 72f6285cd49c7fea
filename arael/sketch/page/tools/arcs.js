/** Arcs: through three points, about a centre, tangent to what they go on from. */

import { arcAbout, arcMiddle, arcTangent, arcThrough } from "../geometry/construct.js";
import { curveOf, line, tangentAt } from "../geometry/curves.js";
import { endNames, splitHandle } from "../geometry/handles.js";
import { add, angleOf, dist, polar, positive, signed, sub, times, unit } from "../geometry/vectors.js";
import { coordinate, dimension, extras } from "./compose.js";
import { PointsTool, movedTo } from "./points.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../app.js").App} App
 */

class ThreePointArc extends PointsTool {
  /** @param {App} app */
  constructor(app) {
    super(app, ["start of the arc", "end of the arc", "a point that it passes; type the radius"]);
  }

  fields() {
    const [a, b, c] = this.all.map((place) => place.at);
    const arc = this.places.length === 2 && c ? arcThrough(a, b, c) : null;
    return arc ? [this.field("radius", "radius", arc.rx)] : [];
  }

  /** @param {Place[]} places */
  compose([a, b, c]) {
    if (!arcThrough(a.at, b.at, c.at)) return null;
    return {
      text: `add_arc ${[a, b, c].map((place) => coordinate(place.at)).join(" ")} noconnect notangent`,
      extras: [...extras(a, "_.start"), ...extras(b, "_.end"), ...dimension("radius", "_", this.typed.text("radius"))],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const [a, b, c] = points;
    const arc = c ? arcThrough(a, b, c) : null;
    return { curves: arc ? [arc] : b ? [line(a, b)] : [], points };
  }
}

class CentreArc extends PointsTool {
  clockwise = false;

  /** @param {App} app */
  constructor(app) {
    super(app, ["centre of the arc", "its start; type the radius", "its end; type the angle; Shift: the other way round"]);
  }

  fields() {
    const [m, a] = this.places.map((place) => place.at);
    if (!m || !this.place) return [];
    const p = this.adjusted(this.place).at;
    if (!a) return [this.field("radius", "radius", dist(m, p))];
    return [this.field("sweep", "angle", (Math.abs(arcAbout(m, a, p, this.clockwise).sweep) * 180) / Math.PI, "angle")];
  }

  /** @param {Place} place */
  adjusted(place) {
    const [m, a] = this.places.map((one) => one.at);
    if (!m) return place;
    if (!a) {
      const radius = this.typed.number("radius", dist(m, place.at));
      return this.typed.any ? movedTo(place, add(m, times(unit(sub(place.at, m)), radius))) : place;
    }
    const sweep = (this.typed.number("sweep", NaN) * Math.PI) / 180;
    if (!Number.isFinite(sweep)) return place;
    const angle = angleOf(sub(a, m)) + (this.clockwise ? -sweep : sweep);
    return movedTo(place, add(m, times(polar(angle), dist(m, a))));
  }

  /** The way round is that in which the pointer turns. @param {Place} place @param {PointerEvent|null} [event] */
  move(place, event) {
    const [m, a] = this.places.map((one) => one.at);
    if (m && a) {
      const turn = signed(angleOf(sub(place.at, m)) - angleOf(sub(a, m)));
      if (Math.abs(turn) < 1) this.clockwise = turn < 0;
      if (event?.shiftKey) this.clockwise = turn > 0;
    }
    super.move(place, event);
  }

  stepDone() {
    this.radius = this.typed.text("radius") || this.radius;
    this.typed.clear();
  }

  radius = "";

  cancel() {
    super.cancel();
    this.radius = "";
  }

  /** @param {Place[]} places */
  compose([m, a, b]) {
    const arc = arcAbout(m.at, a.at, b.at, this.clockwise);
    const end = add(m.at, times(unit(sub(b.at, m.at)), arc.rx));
    if (positive(arc.sweep) < 1e-9) return null;
    const reached = dist(end, b.at) < 1e-9 * (1 + arc.rx);
    return {
      text: `add_arc ${coordinate(a.at)} ${coordinate(end)} ${coordinate(arcMiddle(arc))} noconnect notangent`,
      extras: [
        ...extras(m, "_.center"),
        ...extras(a, "_.start"),
        ...(reached ? extras(b, "_.end") : []),
        ...dimension("radius", "_", this.radius),
        ...dimension("sweep", "_", this.typed.text("sweep")),
      ],
    };
  }

  preview() {
    const [m, a, b] = this.all.map((place) => place.at);
    if (!a) return { points: m ? [m] : [] };
    if (!b) return { guides: [line(m, a)], points: [m, a] };
    return { curves: [arcAbout(m, a, b, this.clockwise)], guides: [line(m, a), line(m, b)], points: [m] };
  }
}

class TangentArc extends PointsTool {
  /** Handle of the end that it goes on from. */
  from = "";

  /** @param {App} app */
  constructor(app) {
    super(app, ["end of a line or arc to go on from", "end of the arc"]);
  }

  /** @param {Place} place */
  click(place) {
    if (!this.places.length) {
      const handle = place.snap?.handles.find((one) => this.direction(one)) ?? "";
      if (!handle) return;
      this.from = handle;
    }
    super.click(place);
  }

  /** Direction in which a curve leaves its end. @param {string} handle @returns {Point|null} */
  direction(handle) {
    const [name, point] = splitHandle(handle);
    const entity = this.app.store.entities.get(name);
    const curve = entity && curveOf(entity, this.app.store.values);
    if (!entity || !curve || !endNames(entity).includes(point)) return null;
    // the numbers of an arc that was drawn clockwise run from its end to its start
    const atEnd = (point === "p2" || point === "end") !== !!entity.clockwise;
    const t = tangentAt(curve, atEnd ? 1 : 0);
    return atEnd ? t : times(t, -1);
  }

  get arc() {
    const [a, b] = this.all.map((place) => place.at);
    const direction = this.from ? this.direction(this.from) : null;
    return a && b && direction ? arcTangent(a, direction, b) : null;
  }

  /** @param {Place[]} places */
  compose([a, b]) {
    const { arc, from } = this;
    if (!arc) return null;
    return {
      text: `add_arc ${coordinate(a.at)} ${coordinate(b.at)} ${coordinate(arcMiddle(arc))} noconnect notangent`,
      extras: [`coincident _.start ${from}`, `tangent ${splitHandle(from)[0]} _`, ...extras(b, "_.end")],
    };
  }

  cancel() {
    super.cancel();
    this.from = "";
  }

  preview() {
    const { arc } = this;
    const points = this.all.map((place) => place.at);
    const straight = points.length === 2 && !arc;
    return { curves: arc ? [arc] : straight ? [line(points[0], points[1])] : [], points };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const ARCS = [
  { id: "arc", title: "Arc by three points", key: "a", group: "create", hint: "start, end, and a point between", make: (app) => new ThreePointArc(app) },
  { id: "arc_center", title: "Arc about a centre", key: "Shift+A", group: "create", hint: "centre, start, end", make: (app) => new CentreArc(app) },
  { id: "arc_tangent", title: "Tangent arc", key: "Shift+L", group: "create", hint: "goes on from the end of a line or arc", make: (app) => new TangentArc(app) },
];
