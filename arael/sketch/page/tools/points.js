/** Tools that collect places and then run one command. */

import { dist } from "../geometry/vectors.js";
import { Tool } from "./tool.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Field} Field
 * @typedef {import("../types.js").ToolSpec} ToolSpec
 * @typedef {import("./compose.js").Command} Command
 */

/** A tool of a fixed number of places; `hints` has one text for each. */
export class PointsTool extends Tool {
  /** @type {Place[]} */
  places = [];

  /** @param {import("../app.js").App} app @param {string[]} hints */
  constructor(app, hints) {
    super(app);
    this.hints = hints;
  }

  get hint() {
    return this.hints[Math.min(this.places.length, this.hints.length - 1)];
  }

  get begun() {
    return this.places.length > 0;
  }

  /** @returns {import("./tool.js").SnapContext} */
  context() {
    return { from: null, draws: "point", extra: this.places.map((place) => place.at) };
  }

  /** Places with the one under the pointer, moved to what was typed. */
  get all() {
    return this.place && this.places.length < this.hints.length
      ? [...this.places, this.adjusted(this.place)]
      : this.places;
  }

  /** A place moved to the typed values. @param {Place} place @returns {Place} */
  adjusted(place) {
    return place;
  }

  /** Whether two places in a row may be the same. */
  get distinct() {
    return true;
  }

  /** @param {Place} place */
  click(place) {
    const next = this.adjusted(place);
    const last = this.places.at(-1);
    if (this.distinct && last && dist(last.at, next.at) * this.app.view.scale < 1e-3) return;
    this.places.push(next);
    if (this.places.length < this.hints.length) {
      this.stepDone();
      this.stepped();
    } else void this.commit();
  }

  /** A place was taken: typed values were for it. */
  stepDone() {
    this.typed.clear();
  }

  /** Run the command of the places. */
  async commit() {
    const command = this.compose(this.places);
    this.cancel();
    this.stepped();
    if (!command) return;
    await this.app.run(command.text, { extras: command.extras });
  }

  /** @param {Place[]} _places @returns {Command|null} */
  compose(_places) {
    return null;
  }

  cancel() {
    super.cancel();
    this.places = [];
  }

  /** A field for typing. @param {string} id @param {string} title @param {number} value @param {Field["quantity"]} [quantity] @returns {Field} */
  field(id, title, value, quantity = "length") {
    return { id, title, value, quantity, text: this.typed.text(id) };
  }
}

/** A place that was moved: its snap does not hold any more. @param {Place} place @param {Point} at @returns {Place} */
export function movedTo(place, at) {
  const moved = dist(place.at, at) > 1e-12 * (1 + Math.hypot(...at));
  return moved ? { ...place, at, snap: null } : place;
}
