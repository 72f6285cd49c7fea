/** Fillets and chamfers: corners by one end or two lines, then the size. */

import { PicksTool } from "./picks.js";
import { splitHandle } from "../geometry/handles.js";
import { short } from "./compose.js";

/** @typedef {import("../app.js").App} App */

/** The size that was used last, as it was typed. @type {Record<string, string>} */
const sizes = { fillet: "", chamfer: "" };

class CornerTool extends PicksTool {
  /** @param {App} app @param {"fillet"|"chamfer"} word */
  constructor(app, word) {
    super(app, ["line", "pointlike"], Infinity);
    this.word = word;
  }

  get hint() {
    const size = this.word === "fillet" ? "radius" : "distance";
    return this.names.length ? `more corners, or type the ${size} and press Enter` : "a corner, or two lines that meet";
  }

  /** @param {import("../pick.js").Pick} pick */
  accepts(pick) {
    if (pick.type === "point" && !/\.p[12]$/.test(pick.name)) return false;
    return super.accepts(pick) && this.app.store.entities.get(splitHandle(pick.name)[0])?.kind === "line";
  }

  fields() {
    if (!this.names.length) return [];
    const title = this.word === "fillet" ? "radius" : "distance";
    return [{ id: "size", title, text: this.typed.text("size"), value: this.usual, quantity: /** @type {const} */ ("length") }];
  }

  /** Size if none is typed: what was used last, else thirty pixels. */
  get usual() {
    const last = Number(sizes[this.word]);
    return last > 0 ? last : this.app.view.gridStep(24);
  }

  text() {
    void this.commit();
  }

  finish() {
    if (this.names.length) void this.commit();
  }

  compose() {
    const typed = this.typed.text("size");
    if (typed) sizes[this.word] = typed;
    return { text: `${this.word} ${this.names.join(" ")} ${this.typed.word("size") || short(this.usual)}`, extras: [] };
  }
}

/** @type {import("../types.js").ToolSpec[]} */
export const CORNERS = [
  { id: "fillet", title: "Fillet", key: "f", group: "modify", hint: "rounds corners", make: (app) => new CornerTool(app, "fillet") },
  { id: "chamfer", title: "Chamfer", key: "Shift+F", group: "modify", hint: "bevels corners", make: (app) => new CornerTool(app, "chamfer") },
];
