/** Measures one thing, or two: distance, angle, length; nothing is added to the sketch. */

import { CURVES, PicksTool } from "./picks.js";

/** Lines of a label. */
const MOST = 4;

/** What a label shows: the first lines, without what is not so (`parallel: no`). @param {string[]} lines */
export const told = (lines) => lines.filter((line) => !line.endsWith(": no")).slice(0, MOST);

export class MeasureTool extends PicksTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "measure", title: "Measure", key: "i", group: "dimension", hint: "one thing, or two",
    make: (app) => new MeasureTool(app),
  };

  /** What was measured last: `distance: 5`. */
  /** @type {string[]} */
  lines = [];
  /** @type {import("../types.js").Point|null} */
  resultAt = null;

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["point", "pointlike", ...CURVES], 2);
  }

  get hint() {
    return this.lines.join(" · ") || "what to measure; a second thing for their distance and angle";
  }

  get needsPlace() {
    return true;
  }

  get picks() {
    return true;
  }

  get picking() {
    return true;
  }

  /** @param {string} name @param {import("../types.js").Place} place */
  picked(name, place) {
    if (this.names.length === 2) this.names.length = 0;
    super.picked(name, place);
    void this.measure(place);
  }

  /** @param {import("../types.js").Place} place */
  async measure(place) {
    const reply = await this.app.wire.ask("measure", { names: this.names.join(" ") });
    this.lines = (reply.ok ? reply.text : reply.error?.message ?? reply.text).split("\n");
    this.resultAt = place.at;
    this.stepped();
  }

  cancel() {
    super.cancel();
    this.lines = [];
  }

  preview() {
    const text = told(this.lines).join("\n");
    const labels = this.resultAt && text ? [{ at: this.resultAt, text }] : [];
    return { names: this.names, labels };
  }
}
