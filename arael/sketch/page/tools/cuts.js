/** Trim, split and extend: one click on the stretch or end that is meant. */

import { CURVES, PicksTool } from "./picks.js";
import { coordinate } from "./compose.js";
import { curveOf, nearest, pointAt, tangentAt } from "../geometry/curves.js";
import { crossings } from "../geometry/intersect.js";
import { dist } from "../geometry/vectors.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 */

class CutTool extends PicksTool {
  /** @type {Point|null} */
  at = null;

  /** @param {App} app @param {"trim"|"split"|"extend"} word */
  constructor(app, word) {
    super(app, word === "extend" ? ["line", "arc"] : CURVES, 1);
    this.word = word;
  }

  get hint() {
    return { trim: "the stretch to delete", split: "where to cut", extend: "the end to lengthen" }[this.word];
  }

  get begun() {
    return false;
  }

  /** @param {string} name @param {Place} place */
  picked(name, place) {
    super.picked(name, place);
    this.at = this.app.view.toWorld(place.screen);
  }

  compose() {
    return this.at ? { text: `${this.word} ${this.names[0]} ${coordinate(this.at)}`, extras: [] } : null;
  }

  /** Where the curve would be cut. */
  preview() {
    const preview = super.preview();
    const { store } = this.app;
    const entity = store.entities.get(this.under);
    const curve = entity && curveOf(entity, store.values);
    if (!curve || !this.place) return preview;
    const at = this.app.view.toWorld(this.place.screen);
    if (this.word === "extend") {
      const ends = [pointAt(curve, 0), pointAt(curve, 1)];
      return { ...preview, points: [dist(at, ends[0]) < dist(at, ends[1]) ? ends[0] : ends[1]] };
    }
    /** @type {Point[]} */
    const points = [];
    for (const other of store.entities.values()) {
      const crossing = other.name !== this.under && curveOf(other, store.values);
      if (crossing && points.length < 100) points.push(...crossings(curve, crossing));
    }
    const here = nearest(curve, at).t;
    const ts = points.map((p) => ({ p, t: nearest(curve, p).t })).sort((a, b) => a.t - b.t);
    const beside = [ts.filter(({ t }) => t < here).at(-1), ts.find(({ t }) => t > here)];
    const cuts = beside.flatMap((one) => (one ? [{ at: one.p, along: tangentAt(curve, one.t) }] : []));
    return { ...preview, cuts };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const CUTS = [
  { id: "trim", title: "Trim", key: "w", group: "modify", hint: "deletes a stretch between crossings", make: (app) => new CutTool(app, "trim") },
  { id: "split", title: "Split", key: "q", group: "modify", hint: "cuts at the crossings beside a place", make: (app) => new CutTool(app, "split") },
  { id: "extend", title: "Extend", key: "Shift+N", group: "modify", hint: "lengthens up to the next curve", make: (app) => new CutTool(app, "extend") },
];
