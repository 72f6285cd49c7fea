/** The unit in which lengths are shown and typed. It never changes the part, whose unit is the document's. */

import { amountText, shown } from "./amounts.js";
import { quantityOf } from "./draw/texts.js";
import { remember, remembered } from "./memory.js";

/**
 * @typedef {import("./types.js").Dimension} Dimension
 * @typedef {"length"|"area"|"angle"} Quantity
 */

/** @type {Readonly<Record<string, number>>} */
export const MILLIMETRES = { mm: 1, cm: 10, m: 1000, in: 25.4 };
export const UNITS = Object.keys(MILLIMETRES);

const KEY = "unit";
const NUMBER = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;
/** Numbers that are added, multiplied and so on. */
const ARITHMETIC = /^[\d.\s()+*/-]*\d[\d.\s()+*/-]*$/;

export class Lengths {
  /** As chosen in the menu; "": the unit of the part. */
  chosen = UNITS.find((unit) => unit === remembered(KEY)) ?? "";

  /** @param {{unit: string}} store  knows the unit of the part */
  constructor(store) {
    this.store = store;
  }

  /** The unit that is shown. */
  get name() {
    return this.chosen || this.store.unit;
  }

  /** Whether it is another one than that of the part. */
  get other() {
    return this.name !== this.store.unit && this.store.unit in MILLIMETRES;
  }

  /** Number that is shown for a length of 1 in the unit of the part. */
  get factor() {
    return this.other ? MILLIMETRES[this.store.unit] / MILLIMETRES[this.name] : 1;
  }

  /** Show lengths in a unit; that of the part stays that of the part when it changes. @param {string} unit */
  set(unit) {
    this.chosen = unit === this.store.unit ? "" : unit;
    remember(KEY, this.chosen);
  }

  /** A number of the part as it is shown, without its unit. @param {number} number @param {Quantity} quantity */
  number(number, quantity) {
    return quantity === "angle" ? number : number * (quantity === "area" ? this.factor ** 2 : this.factor);
  }

  /** A number of the part as it would be typed; with its unit where that is not the part's. @param {number} number @param {Quantity} quantity */
  text(number, quantity) {
    const text = shown(this.number(number, quantity));
    return this.other && quantity === "length" ? `${text} ${this.name}` : text;
  }

  /** The value of a dimension as it would be typed: numbers are converted, expressions stay. @param {Dimension} record */
  amount(record) {
    if (!this.other) return amountText(record);
    const quantity = quantityOf(record.kind);
    /** @param {import("./types.js").Amount|null|undefined} one */
    const converted = (one) => one && (NUMBER.test(one.text.trim()) ? { ...one, text: this.text(one.number, quantity) } : one);
    const { value, low, high } = record;
    return amountText({ ...record, value: converted(value), low: converted(low), high: converted(high) });
  }

  /**
   * What was typed, for a command: plain numbers are in the unit that is shown.
   * @param {string} text
   * @param {Quantity} quantity
   */
  typed(text, quantity) {
    if (!this.other || quantity === "angle") return text;
    /** @param {string} part */
    const one = (part) => {
      if (quantity === "area") {
        const square = this.factor ** 2;
        return NUMBER.test(part) ? String(Number(part) / square) : ARITHMETIC.test(part) ? `(${part}) * ${1 / square}` : part;
      }
      return NUMBER.test(part) ? `${part} ${this.name}` : ARITHMETIC.test(part) ? `(${part}) * 1 ${this.name}` : part;
    };
    const [, sign = "", rest = ""] = /^\s*(=|[<>]=)?\s*(.*?)\s*$/s.exec(text) ?? [];
    return `${sign}${sign.length > 1 ? " " : ""}${rest.split(/\s+to\s+/).map(one).join(" to ")}`;
  }
}
