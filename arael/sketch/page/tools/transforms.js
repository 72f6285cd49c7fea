/** Move, rotate and scale the selection: from a place to a place, or by a typed value. */

import { CURVES, PicksTool } from "./picks.js";
import { copies } from "./copies.js";
import { coordinate, degrees, short } from "./compose.js";
import { angleOf, dist, mix, sub, turned } from "../geometry/vectors.js";
import { line } from "../geometry/curves.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {"move"|"rotate"|"scale"} Word
 */

/** What each step asks for. @type {Record<Word, string[]>} */
const HINTS = {
  move: ["from where", "to where"],
  rotate: ["centre to turn about; type the angle then", "from which direction", "to which direction"],
  scale: ["centre to scale about; type the factor then", "a distance from it", "what that distance becomes"],
};

class TransformTool extends PicksTool {
  /** @type {Point[]} */
  places = [];

  /** @param {App} app @param {Word} word */
  constructor(app, word) {
    super(app, ["point", ...CURVES], Infinity);
    this.word = word;
    this.names = this.selected();
    this.placing = this.names.length > 0;
  }

  get hint() {
    return this.placing ? HINTS[this.word][this.places.length] : `what to ${this.word}; Enter goes on`;
  }

  get picking() {
    return !this.placing;
  }

  context() {
    return { from: null, draws: /** @type {const} */ ("none"), extra: this.places };
  }

  /** Points with the one under the pointer. */
  get all() {
    return this.place && this.placing ? [...this.places, this.place.at] : this.places;
  }

  get angle() {
    const [m, a, b] = this.all;
    return b ? angleOf(sub(b, m)) - angleOf(sub(a, m)) : 0;
  }

  get factor() {
    const [m, a, b] = this.all;
    const given = b && dist(m, a) > 0 ? dist(m, b) / dist(m, a) : 1;
    return this.typed.number("factor", given);
  }

  fields() {
    if (!this.places.length || this.word === "move") return [];
    if (this.word === "rotate") {
      const value = this.typed.number("angle", (this.angle * 180) / Math.PI);
      return [{ id: "angle", title: "angle", value, text: this.typed.text("angle"), quantity: /** @type {const} */ ("angle") }];
    }
    return [{ id: "factor", title: "factor", value: this.factor, text: this.typed.text("factor"), quantity: /** @type {const} */ ("count") }];
  }

  text() {
    void this.commit();
  }

  /** @param {Place} place */
  click(place) {
    if (!this.placing) return super.click(place);
    this.place = place;
    this.places.push(place.at);
    if (this.places.length < HINTS[this.word].length) this.stepped();
    else {
      this.place = null;
      void this.commit();
    }
  }

  finish() {
    if (this.names.length) this.placing = true;
    this.stepped();
  }

  compose() {
    const names = this.names.join(" ");
    const [m, a] = this.all;
    if (this.word === "move") return a ? { text: `move ${names} @${coordinate(sub(a, m))}`, extras: [] } : null;
    const value = this.word === "rotate" ? this.typed.word("angle") || degrees(this.angle) : this.typed.word("factor") || short(this.factor);
    return { text: `${this.word} ${names} about ${coordinate(m)} ${value}`, extras: [] };
  }

  cancel() {
    super.cancel();
    this.placing = false;
    this.places = [];
  }

  /**
   * Ends of the guides: a typed value takes the place of the pointer's.
   * @param {Point} m
   * @param {Point[]} given  from which direction or distance, and to which
   * @param {number} angle
   * @param {Point} middle  of the selection: what is turned is seen from there as long as no direction is given
   * @returns {Point[]}
   */
  _rays(m, given, angle, middle) {
    const a = this.places.length < 2 && dist(m, middle) > 0 ? middle : given[0];
    if (this.word === "rotate" && this.typed.text("angle")) return [a, turned(a, m, angle)];
    if (this.word === "scale" && this.typed.text("factor")) return [mix(m, a, this.factor)];
    return given;
  }

  preview() {
    const preview = super.preview();
    const points = this.all;
    const [m, a] = points;
    if (!this.placing || !a) return { ...preview, points };
    const made = copies(this.app.store, this.names);
    if (this.word === "move") return { ...preview, points, guides: [line(m, a)], curves: made.moved(sub(a, m)) };
    const angle = (this.typed.number("angle", (this.angle * 180) / Math.PI) * Math.PI) / 180;
    const rays = this._rays(m, points.slice(1), angle, made.middle);
    const guides = rays.map((p) => line(m, p));
    return { ...preview, points: [m, ...rays], guides, curves: this.word === "rotate" ? made.turned(m, angle) : made.scaled(m, this.factor) };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const TRANSFORMS = [
  { id: "move", title: "Move", key: "Shift+J", group: "modify", hint: "shifts the selection", make: (app) => new TransformTool(app, "move") },
  { id: "rotate", title: "Rotate", key: "Shift+K", group: "modify", hint: "turns the selection", make: (app) => new TransformTool(app, "rotate") },
  { id: "scale", title: "Scale", key: "Shift+S", group: "modify", hint: "scales the selection", make: (app) => new TransformTool(app, "scale") },
];
