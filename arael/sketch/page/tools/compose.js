/** Texts of commands: coordinates, numbers, automatic constraints. */

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Place} Place
 * @typedef {{text: string, extras: string[]}} Command
 */

/** A number as commands read it, without an exponent where that is possible. @param {number} x */
export function number(x) {
  const text = String(x === 0 ? 0 : x);
  if (!text.includes("e")) return text;
  return Math.abs(x) < 1 ? trimmed(x.toFixed(20)) : String(BigInt(Math.round(x)));
}

/** @param {string} text */
const trimmed = (text) => text.replace(/\.?0+$/, "") || "0";

/** A coordinate. @param {Point} p */
export const coordinate = (p) => `${number(p[0])},${number(p[1])}`;

/** Degrees of an angle, to a millionth. @param {number} radians */
export const degrees = (radians) => number(Number(((radians * 180) / Math.PI).toFixed(6)));

/** A length for a command, to nine digits: what a pointer gives is not known better. @param {number} x */
export const short = (x) => number(Number(x.toPrecision(9)));

/** A text as a word of a command. @param {string} text */
export const quoted = (text) => `"${text.replaceAll('"', '""')}"`;

/**
 * What was typed as one word of a command, whatever it holds: it can neither end the command nor begin another.
 * @param {string} text
 */
export const argument = (text) => (/^[\w.]+$/.test(text) ? text : quoted(text));

/** An expression without a leading `=`: in the page `=width` follows `width`, in commands it takes the value once. @param {string} text */
export const linked = (text) => text.trim().replace(/^=(?!=)\s*/, "");

/**
 * A typed value of a dimension as words of a command: an expression, `>= x`, `<= x` or `x to y`.
 * @param {string} text
 */
export function amount(text) {
  const bound = /^([<>]=)(.*)$/.exec(text);
  if (bound) return `${bound[1]} ${argument(bound[2].trim())}`;
  return linked(text).split(/\s+to\s+/).map(argument).join(" to ");
}

/**
 * Automatic constraints of a place.
 * @param {Place} place
 * @param {string} point  handle of the new point there
 * @param {string} [curve]  name of the new curve; without it constraints of the curve are left out
 * @returns {string[]}
 */
export function extras(place, point, curve = "") {
  if (!place.snap || place.bare) return [];
  return place.snap.extras
    .filter((text) => (curve || !text.includes("{c}")) && (point || !text.includes("{p}")))
    .map((text) => text.replaceAll("{p}", point).replaceAll("{c}", curve));
}

/**
 * A dimension of a typed value.
 * @param {string} kind
 * @param {string} args
 * @param {string} text  "" if nothing was typed
 * @returns {string[]}
 */
export const dimension = (kind, args, text) => (text ? [`${kind} ${args} ${amount(text)}`] : []);
