/** Values typed while drawing: one text for every field, one of which takes the keys. */

/** @typedef {import("../types.js").Field} Field */

import { argument, linked } from "./compose.js";

const FIRST = /^[0-9.\-+]$/;
/** What makes more than a number of a value. */
const EXPRESSION = /^[a-z_=(]$/i;

export class Typed {
  /** @type {Map<string, string>} */
  texts = new Map();
  /** Fields that are lengths. @type {Set<string>} */
  _lengths = new Set();
  /** Values of expressions, in the unit of the part. @type {Map<string, number>} */
  _numbers = new Map();
  active = 0;
  open = false;

  /** @param {import("../lengths.js").Lengths} lengths */
  constructor(lengths) {
    this.lengths = lengths;
  }

  clear() {
    this.texts.clear();
    this._numbers.clear();
    this.active = 0;
    this.open = false;
  }

  /**
   * Write an expression into a field.
   * @param {Field} field
   * @param {string} text
   * @param {number} [number]  its value, if that is known
   */
  write({ id, quantity }, text, number = NaN) {
    if (quantity === "length") this._lengths.add(id);
    this.texts.set(id, text);
    this._numbers.set(id, number);
  }

  /**
   * What was typed for a field, with the unit that is shown; "" if nothing.
   * @param {string} id
   */
  text(id) {
    const text = linked(this.texts.get(id) ?? "");
    return text && this._lengths.has(id) ? this.lengths.typed(text, "length") : text;
  }

  /**
   * The same as a word of a command.
   * @param {string} id
   */
  word(id) {
    const text = this.text(id);
    return text && argument(text);
  }

  /**
   * The number that was typed for a field, or that of its expression; else what the pointer gives.
   * @param {string} id
   * @param {number} otherwise
   */
  number(id, otherwise) {
    const text = (this.texts.get(id) ?? "").trim();
    const number = text === "" ? NaN : Number(text);
    const value = this._numbers.get(id) ?? NaN;
    if (!Number.isFinite(number)) return text !== "" && Number.isFinite(value) ? value : otherwise;
    return this._lengths.has(id) ? number / this.lengths.factor : number;
  }

  /** Whether anything was typed. */
  get any() {
    return [...this.texts.values()].some((text) => text.trim() !== "");
  }

  /**
   * A key, given the fields of this step.
   * @param {KeyboardEvent} event
   * @param {Field[]} fields
   * @param {boolean} [begun]  something is being drawn: letters begin a value, too
   * @returns {"" | "changed" | "enter" | "expression"} empty if it was not for a value; an expression goes on
   *     with this key in a place where names complete
   */
  key(event, fields, begun = false) {
    if (!fields.length || event.ctrlKey || event.metaKey || event.altKey) return "";
    this.active = Math.min(this.active, fields.length - 1);
    const { id, quantity } = fields[this.active];
    if (quantity === "length") this._lengths.add(id);
    const text = this.texts.get(id) ?? "";
    if (event.key === "Tab") {
      const step = event.shiftKey ? fields.length - 1 : 1;
      if (this.open) this.active = (this.active + step) % fields.length;
      this.open = true;
      return "changed";
    }
    if (event.key === "Enter") {
      if (!this.any) return "";
      this.open = false;
      return "enter";
    }
    if (event.key === "Backspace" && text) {
      this.texts.set(id, text.slice(0, -1));
      return "changed";
    }
    const goesOn = this.open || text !== "";
    const begins = FIRST.test(event.key) || (begun ? EXPRESSION : /^[=(]$/).test(event.key);
    if (event.key.length !== 1 || (!goesOn && !begins)) return "";
    if (quantity !== "text" && EXPRESSION.test(event.key)) {
      this.open = true;
      return "expression";
    }
    this.texts.set(id, text + event.key);
    this.open = true;
    return "changed";
  }
}
