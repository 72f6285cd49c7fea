/** Values typed while drawing: one text for every field, one of which takes the keys. */

/** @typedef {import("../types.js").Field} Field */

import { argument } from "./compose.js";

const FIRST = /^[0-9.\-+=(]$/;

export class Typed {
  /** @type {Map<string, string>} */
  texts = new Map();
  /** Fields that are lengths. @type {Set<string>} */
  _lengths = new Set();
  active = 0;
  open = false;

  /** @param {import("../lengths.js").Lengths} lengths */
  constructor(lengths) {
    this.lengths = lengths;
  }

  clear() {
    this.texts.clear();
    this.active = 0;
    this.open = false;
  }

  /**
   * What was typed for a field, with the unit that is shown; "" if nothing.
   * @param {string} id
   */
  text(id) {
    const text = (this.texts.get(id) ?? "").trim();
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
   * A plain number that was typed for a field, else what the pointer gives.
   * @param {string} id
   * @param {number} otherwise
   */
  number(id, otherwise) {
    const text = (this.texts.get(id) ?? "").trim();
    const number = text === "" ? NaN : Number(text);
    if (!Number.isFinite(number)) return otherwise;
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
   * @returns {"" | "changed" | "enter"} empty if it was not for a value
   */
  key(event, fields) {
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
    const writes = event.key.length === 1 && (this.open || text !== "" || FIRST.test(event.key));
    if (!writes) return "";
    this.texts.set(id, text + event.key);
    this.open = true;
    return "changed";
  }
}
