/** Measures one thing, or two: distance, angle, length; nothing is added to the sketch. */

import { CURVES, PicksTool } from "./picks.js";

export class MeasureTool extends PicksTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "measure", title: "Measure", key: "i", group: "dimension", hint: "one thing, or two",
    make: (app) => new MeasureTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["point", "pointlike", ...CURVES], 2);
    /** What was measured last. */
    this.result = "";
    /** @type {import("../types.js").Point|null} */
    this.resultAt = null;
  }

  get hint() {
    return this.result || "what to measure; a second thing for their distance and angle";
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
    const reply = await this.app.wire.run(`measure ${this.names.join(" ")}`);
    this.result = reply.ok ? reply.text : reply.error?.message ?? reply.text;
    this.resultAt = place.at;
    this.stepped();
  }

  cancel() {
    super.cancel();
    this.result = "";
  }

  preview() {
    const lines = this.result.split("\n");
    const labels = this.resultAt && this.result ? [{ at: this.resultAt, text: lines.slice(0, 2).join("; ") }] : [];
    return { names: this.names, labels };
  }
}
