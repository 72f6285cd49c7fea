/** Fillets and chamfers: corners by one end or two lines, then the size. */

import { PicksTool } from "./picks.js";
import { arcAbout } from "../geometry/construct.js";
import { line } from "../geometry/curves.js";
import { splitHandle } from "../geometry/handles.js";
import { add, cross, dist, dot, sub, times, unit } from "../geometry/vectors.js";
import { short } from "./compose.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../types.js").Point} Point
 */

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

  /** The corners as they would become, of what is picked and what is under the pointer. */
  preview() {
    const { store } = this.app;
    const size = this.typed.number("size", this.usual);
    /** @type {import("../types.js").Curve[]} */
    const curves = [];
    /** @type {{at: Point, text: string}[]} */
    const labels = [];
    for (const { at, first, second } of cornersOf(store, this.under ? [...this.names, this.under] : this.names)) {
      const cut = this.word === "fillet" ? rounded(at, first, second, size) : bevelled(at, first, second, size);
      if (!cut) continue;
      const shorter = Math.min(dist(at, first), dist(at, second));
      if (cut.trim < shorter * (1 - 1e-9)) curves.push(cut.curve);
      else labels.push({ at, text: `below ${short((size * shorter) / cut.trim)} ${store.unit}` });
    }
    return { ...super.preview(), curves, labels };
  }

  compose() {
    const typed = this.typed.text("size");
    if (typed) sizes[this.word] = typed;
    return { text: `${this.word} ${this.names.join(" ")} ${this.typed.word("size") || short(this.usual)}`, extras: [] };
  }
}

/**
 * Corners that are named by an end of a line or by two lines, as the command reads them.
 * @param {import("../store.js").Store} store
 * @param {string[]} names
 * @returns {{at: Point, first: Point, second: Point}[]}  the corner, and the other ends of both lines
 */
export function cornersOf(store, names) {
  /** @type {Map<string, [Point, Point]>} */
  const lines = new Map();
  for (const { name, kind, text } of store.entities.values()) {
    const ends = kind === "line" && !text && [store.point(`${name}.p1`), store.point(`${name}.p2`)];
    if (ends && ends[0] && ends[1]) lines.set(name, [ends[0], ends[1]]);
  }
  /** @type {{at: Point, first: Point, second: Point}[]} */
  const found = [];
  /** @param {string} name @param {string} other @param {Point} [at] */
  const meeting = (name, other, at) => {
    const [one, two] = [lines.get(name), lines.get(other)];
    for (const i of [0, 1]) {
      for (const j of [0, 1]) {
        if (!one || !two || dist(one[i], two[j]) > 1e-6 * dist(one[0], one[1]) || (at && dist(one[i], at) > 0)) continue;
        const [first, second] = [one[1 - i], two[1 - j]];
        // Both lines have an end here, each of which names the corner.
        const equal = (/** @type {Point} */ p, /** @type {Point} */ q) => dist(p, q) === 0;
        const known = found.some((corner) =>
          (equal(corner.first, first) && equal(corner.second, second)) || (equal(corner.first, second) && equal(corner.second, first)));
        if (!known) found.push({ at: one[i], first, second });
      }
    }
  };
  let waiting = "";
  for (const name of names) {
    const [line, point] = splitHandle(name);
    if (point) {
      const at = store.point(name);
      if (at) for (const other of lines.keys()) if (other !== line) meeting(line, other, at);
    } else if (waiting) {
      meeting(waiting, name);
      waiting = "";
    } else waiting = name;
  }
  return found;
}

/** An arc that touches both sides of a corner. @param {Point} at @param {Point} p @param {Point} q @param {number} radius */
function rounded(at, p, q, radius) {
  const [u, v] = [unit(sub(p, at)), unit(sub(q, at))];
  const half = Math.atan2(Math.abs(cross(u, v)), dot(u, v)) / 2;
  if (!(Math.sin(2 * half) > 1e-9)) return null;
  const trim = radius / Math.tan(half);
  const middle = add(at, times(unit(add(u, v)), radius / Math.sin(half)));
  return { trim, curve: arcAbout(middle, add(at, times(u, trim)), add(at, times(v, trim)), cross(u, v) > 0) };
}

/** A line across a corner. @param {Point} at @param {Point} p @param {Point} q @param {number} trim */
function bevelled(at, p, q, trim) {
  return { trim, curve: line(add(at, times(unit(sub(p, at)), trim)), add(at, times(unit(sub(q, at)), trim))) };
}

/** @type {import("../types.js").ToolSpec[]} */
export const CORNERS = [
  { id: "fillet", title: "Fillet", key: "f", group: "modify", hint: "rounds corners", make: (app) => new CornerTool(app, "fillet") },
  { id: "chamfer", title: "Chamfer", key: "Shift+F", group: "modify", hint: "bevels corners", make: (app) => new CornerTool(app, "chamfer") },
];
