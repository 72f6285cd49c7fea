/** Patterns: circular about a centre, rectangular along a vector; the number of instances is typed. */

import { CURVES, PicksTool } from "./picks.js";
import { copies } from "./copies.js";
import { coordinate, short } from "./compose.js";
import { sub } from "../geometry/vectors.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../types.js").Place} Place
 */

class PatternTool extends PicksTool {
  /** @param {App} app @param {"circular"|"rect"} kind */
  constructor(app, kind) {
    super(app, ["point", ...CURVES], Infinity);
    this.kind = kind;
    this.names = this.selected();
    /** Whether the centre or distance is given next. */
    this.placing = this.names.length > 0;
  }

  get hint() {
    if (!this.placing) return "what to repeat; Enter goes on";
    return this.kind === "circular" ? "the centre, a point; type the number" : "how far to the next instance; type the numbers";
  }

  get picking() {
    return !this.placing;
  }

  context() {
    return { from: null, draws: /** @type {const} */ ("none") };
  }

  fields() {
    if (!this.placing) return [];
    const field = (/** @type {string} */ id, /** @type {string} */ title, /** @type {number} */ value) => ({
      id, title, value: this.typed.number(id, value), text: this.typed.text(id), quantity: /** @type {const} */ ("count"),
    });
    return this.kind === "circular" ? [field("count", "number", 6)] : [field("count", "across", 3), field("rows", "up", 1)];
  }

  /** Enter after a number only takes the number. */
  text() {
    this.app.renderer.overlayChanged();
  }

  finish() {
    if (this.names.length) this.placing = true;
    this.stepped();
  }

  /** First place of the selection: distances are measured from it. */
  get from() {
    return copies(this.app.store, this.names).middle;
  }

  compose() {
    const { place } = this;
    if (!place) return null;
    const count = Math.round(this.typed.number("count", this.kind === "circular" ? 6 : 3));
    const names = this.names.join(" ");
    if (this.kind === "circular") {
      const centre = place.snap?.kind === "endpoint" || place.snap?.kind === "centre" ? place.snap.handles[0] : coordinate(place.at);
      return { text: `pattern circular ${names} about ${centre} ${count} full`, extras: [] };
    }
    const [dx, dy] = sub(place.at, this.from);
    const rows = Math.round(this.typed.number("rows", 1));
    const second = rows > 1 ? ` by ${rows} ${short(dy)}` : "";
    return { text: `pattern rect ${names} ${count} ${short(dx)}${second}`, extras: [] };
  }

  cancel() {
    super.cancel();
    this.placing = false;
  }

  preview() {
    const preview = super.preview();
    if (!this.placing || !this.place) return preview;
    const { at } = this.place;
    const made = copies(this.app.store, this.names);
    const count = Math.min(Math.round(this.typed.number("count", this.kind === "circular" ? 6 : 3)), 60);
    const curves = [];
    if (this.kind === "circular") {
      for (let i = 1; i < count; i++) curves.push(...made.turned(at, (2 * Math.PI * i) / count));
    } else {
      const [dx, dy] = sub(at, made.middle);
      const rows = Math.min(Math.round(this.typed.number("rows", 1)), 60);
      for (let i = 0; i < count; i++) for (let j = 0; j < rows; j++) if (i || j) curves.push(...made.moved([i * dx, j * dy]));
    }
    return { ...preview, curves, points: [at] };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const PATTERNS = [
  { id: "pattern_circular", title: "Circular pattern", key: "Shift+Q", group: "modify", hint: "copies about a centre", make: (app) => new PatternTool(app, "circular") },
  { id: "pattern_rect", title: "Rectangular pattern", key: "Shift+P", group: "modify", hint: "copies in rows", make: (app) => new PatternTool(app, "rect") },
];
