/** Mirrored copies of the selection about a line. */

import { CURVES, PicksTool } from "./picks.js";

export class MirrorTool extends PicksTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "mirror", title: "Mirror", key: "y", group: "modify", hint: "mirrored copies about a line",
    make: (app) => new MirrorTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["point", "pointlike", ...CURVES], Infinity);
    this.names = this.selected();
    /** Whether the axis is picked next. */
    this.axis = this.names.length > 0;
  }

  get hint() {
    return this.axis ? "the line to mirror about" : "what to mirror; Enter goes on to the axis";
  }

  /** @param {import("../pick.js").Pick} pick */
  accepts(pick) {
    if (!this.axis) return super.accepts(pick);
    return pick.type === "curve" && this.app.store.entities.get(pick.name)?.kind === "line" && !this.names.includes(pick.name);
  }

  /** @param {string} name @param {import("../types.js").Place} place */
  picked(name, place) {
    if (!this.axis) return super.picked(name, place);
    const sources = this.names.join(" ");
    this.cancel();
    void this.app.run(`mirror ${sources} about ${name}`);
  }

  finish() {
    if (this.names.length) this.axis = true;
    this.stepped();
  }

  cancel() {
    super.cancel();
    this.axis = false;
  }
}
