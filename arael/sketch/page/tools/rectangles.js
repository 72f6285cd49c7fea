/** Rectangles: by opposite corners, by three corners, by centre and corner. */

import { line } from "../geometry/curves.js";
import { rectangleOn } from "../geometry/construct.js";
import { add, dist, foot, sub, times, unit } from "../geometry/vectors.js";
import { coordinate, dimension, extras } from "./compose.js";
import { PointsTool, movedTo } from "./points.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../app.js").App} App
 */

/** @param {Point[]} corners */
const outline = (corners) => corners.map((p, i) => line(p, corners[(i + 1) % corners.length]));

/** Opposite corners, or centre and corner: sides along the axes. */
class LevelRectangle extends PointsTool {
  /** @param {App} app @param {boolean} centred */
  constructor(app, centred) {
    super(app, centred ? ["centre of the rectangle", "a corner"] : ["a corner", "the opposite corner; type width and height"]);
    this.centred = centred;
  }

  fields() {
    const from = this.places[0]?.at;
    if (!from || !this.place) return [];
    const to = this.adjusted(this.place).at;
    const f = this.centred ? 2 : 1;
    return [
      this.field("width", "width", f * Math.abs(to[0] - from[0])),
      this.field("height", "height", f * Math.abs(to[1] - from[1])),
    ];
  }

  /** @param {Place} place */
  adjusted(place) {
    const from = this.places[0]?.at;
    if (!from || !this.typed.any) return place;
    const f = this.centred ? 2 : 1;
    const [x, y] = sub(place.at, from);
    const w = this.typed.number("width", f * Math.abs(x)) / f;
    const h = this.typed.number("height", f * Math.abs(y)) / f;
    return movedTo(place, [from[0] + (x < 0 ? -w : w), from[1] + (y < 0 ? -h : h)]);
  }

  /** @param {Place[]} places */
  compose(places) {
    const [a, b] = places;
    if (a.at[0] === b.at[0] || a.at[1] === b.at[1]) return null;
    const name = this.centred ? "add_rectcenter" : "add_rect";
    return {
      text: `${name} ${coordinate(a.at)} ${coordinate(b.at)} hv noconnect`,
      extras: [
        ...(this.centred ? [] : extras(a, "_0.p1")),
        ...extras(b, "_2.p1"),
        ...dimension("length", "_0", this.typed.text("width")),
        ...dimension("length", "_1", this.typed.text("height")),
      ],
    };
  }

  preview() {
    const [a, b] = this.all.map((place) => place.at);
    if (!a || !b) return { points: a ? [a] : [] };
    const c = this.centred ? sub(times(a, 2), b) : a;
    return { curves: outline([c, [b[0], c[1]], b, [c[0], b[1]]]), points: [a, b] };
  }
}

/** A side, then the height. */
class TurnedRectangle extends PointsTool {
  /** @param {App} app */
  constructor(app) {
    super(app, ["first corner", "second corner: the first side; type its length", "height; type it"]);
  }

  context() {
    const context = super.context();
    return this.places.length === 1 ? { ...context, from: this.places[0].at, draws: /** @type {const} */ ("line") } : context;
  }

  fields() {
    if (!this.place || !this.places.length) return [];
    const to = this.adjusted(this.place).at;
    const [a, b] = this.places.map((place) => place.at);
    return b ? [this.field("height", "height", dist(to, foot(to, a, b)))] : [this.field("width", "width", dist(a, to))];
  }

  /** @param {Place} place */
  adjusted(place) {
    const [a, b] = this.places.map((one) => one.at);
    if (!a || !this.typed.any) return place;
    if (!b) return movedTo(place, add(a, times(unit(sub(place.at, a)), this.typed.number("width", dist(a, place.at)))));
    const f = foot(place.at, a, b);
    const up = sub(place.at, f);
    return movedTo(place, add(f, times(unit(up), this.typed.number("height", Math.hypot(...up)))));
  }

  stepDone() {
    this.width = this.typed.text("width") || this.width;
    this.typed.clear();
  }

  /** What was typed for the first side. */
  width = "";

  cancel() {
    super.cancel();
    this.width = "";
  }

  /** @param {Place[]} places */
  compose([a, b, c]) {
    return {
      text: `add_rect3 ${[a, b, c].map((place) => coordinate(place.at)).join(" ")} noconnect`,
      extras: [
        ...extras(a, "_0.p1"),
        ...extras(b, "_0.p2", "_0"),
        ...dimension("length", "_0", this.width),
        ...dimension("length", "_1", this.typed.text("height")),
      ],
    };
  }

  preview() {
    const [a, b, c] = this.all.map((place) => place.at);
    const curves = c ? outline(rectangleOn(a, b, c)) : b ? [line(a, b)] : [];
    return { curves, points: a ? [a] : [] };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const RECTANGLES = [
  {
    id: "rect", title: "Rectangle", key: "r", group: "create", hint: "by two opposite corners",
    make: (app) => new LevelRectangle(app, false),
  },
  {
    id: "rectcenter", title: "Rectangle about a centre", key: "Shift+R", group: "create", hint: "by its centre and a corner",
    make: (app) => new LevelRectangle(app, true),
  },
  {
    id: "rect3", title: "Rectangle by three corners", key: "Shift+B", group: "create", hint: "a side in any direction, then the height",
    make: (app) => new TurnedRectangle(app),
  },
];
