/** Ellipses, and elliptic arcs: about a centre, by ends and a point, tangent at both ends. */

import { ellipticArc } from "../geometry/construct.js";
import { line, spline } from "../geometry/curves.js";
import { add, angleOf, dist, dot, foot, left, mix, sub, times, unit } from "../geometry/vectors.js";
import { coordinate, degrees, dimension, extras, short } from "./compose.js";
import { PointsTool } from "./points.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../app.js").App} App
 */

/** Frame of an ellipse by its centre, the end of its first axis, and a point at the height of the second. @param {Point} m @param {Point} a @param {Point} p */
function frame(m, a, p) {
  return { rx: dist(m, a), ry: dist(p, foot(p, m, a)), turn: angleOf(sub(a, m)) };
}

/** Eccentric angle of a point's direction. @param {Point} m @param {{rx: number, ry: number, turn: number}} f @param {Point} p */
function eccentric(m, f, p) {
  const u = unit([Math.cos(f.turn), Math.sin(f.turn)]);
  const v = sub(p, m);
  return Math.atan2(dot(v, left(u)) / (f.ry || 1), dot(v, u) / (f.rx || 1));
}

class EllipseTool extends PointsTool {
  /** @param {App} app @param {boolean} part */
  constructor(app, part) {
    super(app, ["centre of the ellipse", "end of its first axis; type the radius", "height of its second axis; type the radius",
      ...(part ? ["start of the arc", "end of the arc, counter-clockwise"] : [])]);
    this.part = part;
    this.radii = ["", ""];
  }

  fields() {
    const [m, a] = this.places.map((place) => place.at);
    if (!m || !this.place) return [];
    const p = this.place.at;
    if (!a) return [this.field("radius", "radius", this.typed.number("radius", dist(m, p)))];
    return this.places.length === 2 ? [this.field("radius", "radius", this.typed.number("radius", dist(p, foot(p, m, a))))] : [];
  }

  /** @param {Place} place @returns {Place} */
  adjusted(place) {
    const [m, a] = this.places.map((one) => one.at);
    const radius = this.typed.number("radius", NaN);
    if (!m || !Number.isFinite(radius)) return place;
    if (!a) return { ...place, at: add(m, times(unit(sub(place.at, m)), radius)), snap: null };
    return { ...place, at: add(mix(m, a, 0.5), times(left(unit(sub(a, m))), radius)), snap: null };
  }

  stepDone() {
    const step = this.places.length - 2;
    if (step === 0 || step === 1) this.radii[step] = this.typed.text("radius");
    this.typed.clear();
  }

  cancel() {
    super.cancel();
    this.radii = ["", ""];
  }

  /** @param {Place[]} places */
  compose(places) {
    const [m, a, p, s, e] = places;
    const f = frame(m.at, a.at, p.at);
    if (!(f.rx > 0 && f.ry > 0)) return null;
    if (!this.part) this.radii[1] = this.typed.text("radius");
    const base = `${coordinate(m.at)} ${short(f.rx)} ${short(f.ry)} ${degrees(f.turn)}`;
    const more = [...extras(m, "_.center"), ...dimension("radius", "_", this.radii[0]), ...dimension("radius_b", "_", this.radii[1])];
    if (!this.part) return { text: `add_ellipse ${base} noconnect`, extras: more };
    const [from, to] = [s, e].map((place) => degrees(eccentric(m.at, f, place.at)));
    return { text: `add_earc_center ${base} ${from} ${to} noconnect notangent`, extras: more };
  }

  preview() {
    const [m, a, p, s, e] = this.all.map((place) => place.at);
    if (!p) return { points: m ? [m] : [], guides: a ? [line(m, a)] : [] };
    const f = frame(m, a, p);
    const whole = { ...ellipticArc(m, f.rx, f.ry, f.turn, 0, 2 * Math.PI), closed: true };
    if (!s) return { curves: [whole], points: [m] };
    const start = eccentric(m, f, s);
    if (!e) return { guides: [whole], points: [m, s] };
    const sweep = (eccentric(m, f, e) - start + 4 * Math.PI) % (2 * Math.PI);
    return { curves: [ellipticArc(m, f.rx, f.ry, f.turn, start, sweep)], guides: [whole], points: [m] };
  }
}

/** Two ends, a point near the arc, and both radii, which can be typed. */
class PassingArc extends PointsTool {
  /** @param {App} app */
  constructor(app) {
    super(app, ["start of the elliptic arc", "its end", "a point near it; type both radii"]);
  }

  get radii() {
    const [a, b] = this.places.map((place) => place.at);
    const p = this.place?.at;
    if (!a || !b || !p) return [0, 0];
    return [this.typed.number("radius", dist(a, b) / 2), this.typed.number("radius_b", Math.max(dist(p, foot(p, a, b)), 1e-3 * dist(a, b)))];
  }

  fields() {
    if (this.places.length < 2) return [];
    const [rx, ry] = this.radii;
    return [this.field("radius", "radius", rx), this.field("radius_b", "second", ry)];
  }

  /** @param {Place[]} places */
  compose([a, b, p]) {
    const [rx, ry] = this.radii;
    return {
      text: `add_earc3 ${[a, b, p].map((place) => coordinate(place.at)).join(" ")} ${short(rx)} ${short(ry)} noconnect`,
      extras: [...extras(a, "_.start"), ...extras(b, "_.end"),
        ...dimension("radius", "_", this.typed.text("radius")), ...dimension("radius_b", "_", this.typed.text("radius_b"))],
    };
  }

  preview() {
    const points = this.all.map((place) => place.at);
    const [a, b, p] = points;
    if (!p) return { points, guides: b ? [line(a, b)] : [] };
    const [rx, ry] = this.radii;
    const side = dot(sub(p, a), left(sub(b, a))) > 0 ? -1 : 1;
    return { curves: [ellipticArc(mix(a, b, 0.5), rx, ry, angleOf(sub(a, b)), 0, side * Math.PI)], points: [a, b] };
  }
}

/** An elliptic arc by its ends and the directions there. */
class DirectedArc extends PointsTool {
  /** @param {App} app */
  constructor(app) {
    super(app, ["start of the elliptic arc", "direction at the start", "its end", "direction at the end"]);
  }

  /** @param {Place[]} places */
  compose([a, u, b, v]) {
    const [s, e] = [sub(u.at, a.at), sub(v.at, b.at)].map((d) => unit(d).map(short).join(","));
    return {
      text: `add_earc_tangent ${coordinate(a.at)} ${s} ${coordinate(b.at)} ${e} noconnect notangent`,
      extras: [...extras(a, "_.start"), ...extras(b, "_.end")],
    };
  }

  preview() {
    const [a, u, b, v] = this.all.map((place) => place.at);
    if (!u) return { points: a ? [a] : [] };
    if (!b) return { points: [a], guides: [line(a, u)] };
    const reach = dist(a, b) / 3;
    const leave = add(a, times(unit(sub(u, a)), reach));
    const arrive = v ? sub(b, times(unit(sub(v, b)), reach)) : mix(leave, b, 0.5);
    return { curves: [spline([a, leave, arrive, b])], guides: v ? [line(b, v)] : [], points: [a, b] };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const ELLIPSES = [
  { id: "ellipse", title: "Ellipse", key: "e", group: "create", hint: "centre and both axes", make: (app) => new EllipseTool(app, false) },
  { id: "earc_center", title: "Elliptic arc about a centre", key: "Shift+E", group: "create", hint: "centre, axes, start, end", make: (app) => new EllipseTool(app, true) },
  { id: "earc3", title: "Elliptic arc by ends and a point", key: "Shift+W", group: "create", hint: "ends, a point near it, both radii", make: (app) => new PassingArc(app) },
  { id: "earc_tangent", title: "Elliptic arc by directions", key: "Shift+U", group: "create", hint: "ends and the directions there", make: (app) => new DirectedArc(app) },
];
