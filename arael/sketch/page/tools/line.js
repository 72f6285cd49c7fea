/** Lines, one after another; an arc goes on tangentially by another tool. */

import { line } from "../geometry/curves.js";
import { add, angleOf, dist, polar, sub, times } from "../geometry/vectors.js";
import { coordinate, dimension, extras } from "./compose.js";
import { PointsTool, movedTo } from "./points.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 */

/** Stands for the coincidence with the line before, whose name its reply brings. */
const CHAIN = "chain";

export class LineTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "line", title: "Line", key: "l", group: "create",
    hint: "lines, each from the end of the last; type a length and an angle",
    make: (app) => new LineTool(app),
  };

  /** Name of the last line of the chain, "" at its start. */
  last = "";
  /** Where the chain began, to close it. @type {string} */
  first = "";
  /** Whether the place that is there is the end of the line before. */
  _chained = false;
  _running = Promise.resolve();

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["start of the line", "end of the line; Enter or a right click ends the chain"]);
  }

  context() {
    const from = this.places[0]?.at ?? null;
    /** @type {import("./tool.js").SnapContext} */
    const context = { from, draws: from ? "line" : "point", lines: this.last ? [this.last] : [] };
    return context;
  }

  fields() {
    const from = this.places[0]?.at;
    if (!from || !this.place) return [];
    const to = this.adjusted(this.place).at;
    return [
      this.field("length", "length", dist(from, to)),
      this.field("angle", "angle", (angleOf(sub(to, from)) * 180) / Math.PI, "angle"),
    ];
  }

  /** @param {Place} place */
  adjusted(place) {
    const from = this.places[0]?.at;
    if (!from || !this.typed.any) return place;
    const v = sub(place.at, from);
    const length = this.typed.number("length", Math.hypot(...v));
    const angle = this.typed.number("angle", (angleOf(v) * 180) / Math.PI);
    const snapped = movedTo(place, add(from, times(polar((angle * Math.PI) / 180), length)));
    // a typed length keeps the direction's own constraint
    const keeps = place.snap?.kind === "alignment" && !this.typed.text("angle");
    return keeps ? { ...snapped, snap: place.snap } : snapped;
  }

  stepDone() {
    this.typed.clear();
  }

  async commit() {
    const [from, to] = this.places;
    const more = [
      ...(from.bare || !this._chained ? extras(from, "_.p1") : [CHAIN]),
      ...extras(to, "_.p2", "_"),
      ...dimension("length", "_", this.typed.text("length")),
      ...dimension("xangle", "_", this.typed.text("angle")),
    ];
    const text = `add_line ${coordinate(from.at)} ${coordinate(to.at)} noconnect notangent`;
    const closes = this.first !== "" && to.snap?.handles.includes(this.first);
    this.typed.clear();
    this.places.splice(0, 2, ...(closes ? [] : [{ ...to, snap: null }]));
    this._chained = !closes;
    this.stepped();
    const before = this._running;
    // the next line refers to this one: replies are awaited in order
    this._running = this._run(before, text, more, !closes);
    await this._running;
  }

  /** @param {Promise<void>} before @param {string} text @param {string[]} more @param {boolean} chains */
  async _run(before, text, more, chains) {
    await before;
    const { last } = this;
    const reply = await this.app.run(text, {
      extras: more.map((one) => (one === CHAIN ? `coincident _.p1 ${last}.p2` : one)),
    });
    const name = reply.created?.find((one) => /^L\d+$/.test(one)) ?? "";
    if (!reply.ok || !name || !chains) {
      this.last = this.first = "";
      if (!reply.ok) this.cancel();
      return;
    }
    if (!last) this.first = `${name}.p1`;
    this.last = name;
    const end = this.app.store.point(`${name}.p2`);
    if (this.places.length === 1 && end) this.places[0] = { ...this.places[0], at: end };
    this.stepped();
  }

  cancel() {
    super.cancel();
    this.last = this.first = "";
    this._chained = false;
  }

  finish() {
    this.cancel();
    this.stepped();
  }

  preview() {
    const [a, b] = this.all.map((place) => place.at);
    return { curves: a && b ? [line(a, b)] : [], points: a ? [a] : [] };
  }
}
