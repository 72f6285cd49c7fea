/** Tools that collect things that are there, then perhaps a place, and run one command. */

import { Tool } from "./tool.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").EntityKind|"end"|"pointlike"} Wanted
 * @typedef {import("./compose.js").Command} Command
 */

/** @type {Wanted[]} */
export const CURVES = ["line", "circle", "arc", "ellipse", "earc", "bezier", "bspline"];

export class PicksTool extends Tool {
  /** @type {string[]} */
  names = [];
  /** What is under the pointer. */
  under = "";

  /**
   * @param {import("../app.js").App} app
   * @param {Wanted[]} wanted  kinds of entities; "pointlike" for any point
   * @param {number} count  how many; Infinity: until Enter
   */
  constructor(app, wanted, count) {
    super(app);
    this.wanted = new Set(wanted);
    this.most = count;
  }

  get begun() {
    return this.names.length > 0;
  }

  /** Whether a place follows the picks. */
  get needsPlace() {
    return false;
  }

  /** Whether things are picked at this step. */
  get picking() {
    return this.names.length < this.most;
  }

  get picks() {
    return this.picking;
  }

  /** @param {import("../pick.js").Pick} pick */
  accepts(pick) {
    if (this.names.includes(pick.name)) return false;
    if (pick.type === "point") return this.wanted.has("pointlike");
    const kind = this.app.store.entities.get(pick.name)?.kind;
    return pick.type === "curve" && !!kind && this.wanted.has(kind);
  }

  /** @param {Place} place */
  move(place) {
    this.under = this.picking ? this.app.picker.at(place.screen, (pick) => this.accepts(pick))?.name ?? "" : "";
    this.app.store.hover(this.under ? [this.under] : []);
    super.move(place);
  }

  /** @param {Place} place */
  click(place) {
    this.place = place;
    if (this.picking) {
      const pick = this.app.picker.at(place.screen, (one) => this.accepts(one));
      if (!pick) return;
      this.picked(pick.name, place);
      if (this.names.length === this.most && !this.needsPlace) void this.commit();
      else this.stepped();
    } else void this.commit();
  }

  /** @param {string} name @param {Place} _place */
  picked(name, _place) {
    this.names.push(name);
    this.app.store.hover([]);
  }

  /** Run the command. */
  async commit() {
    const command = this.compose();
    this.cancel();
    this.stepped();
    if (command) await this.app.run(command.text, { extras: command.extras });
  }

  /** @returns {Command|null} */
  compose() {
    return null;
  }

  cancel() {
    super.cancel();
    this.names = [];
    this.app.store.hover([]);
  }

  preview() {
    /** @type {import("../types.js").Preview} */
    const preview = { names: this.names };
    return preview;
  }

  /** Entities of the selection that this tool can take. */
  selected() {
    const { store } = this.app;
    return [...store.selection].filter((name) => {
      const kind = store.entities.get(name)?.kind;
      return !!kind && this.wanted.has(kind);
    });
  }
}
