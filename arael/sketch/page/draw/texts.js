/** Texts of dimensions and numbers. */

/** @typedef {import("../types.js").Dimension} Dimension */

/** @type {Record<string, string>} */
const PREFIXES = { radius: "R", radius_b: "R", diameter: "⌀", arc_length: "◠ ", total_length: "Σ ", area: "A " };
const ANGLES = new Set(["sweep", "angle", "xangle"]);
const LITERAL = /^\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*(um|mm|cm|m|in|ft|deg|rad|°)?\s*$/i;

/** Up to six digits, without trailing zeros; a true minus sign. @param {number} number */
export function numberText(number) {
  const text = String(Number(number.toPrecision(6)));
  return Number(text) === 0 ? "0" : text.replace("-", "−");
}

/** Whether a dimension's quantity is an angle. @param {string} kind */
const isAngle = (kind) => ANGLES.has(kind);

/**
 * What the drawing shows: value or range with its sign and unit; derived ones in parentheses.
 * @param {Dimension} d
 * @param {string} unit
 * @param {number|null} [measured]  value of a derived dimension now
 */
export function dimensionText(d, unit, measured = null) {
  const suffix = isAngle(d.kind) ? "°" : d.kind === "area" ? ` ${unit}²` : "";
  let body = "";
  if (d.value) {
    const number = d.derived && measured !== null ? measured : d.value.number;
    body = `${!d.derived && !LITERAL.test(d.value.text) ? "ƒ " : ""}${numberText(number)}${suffix}`;
  } else if (d.low && d.high) body = `${numberText(d.low.number)}${suffix} … ${numberText(d.high.number)}${suffix}`;
  else if (d.low) body = `≥ ${numberText(d.low.number)}${suffix}`;
  else if (d.high) body = `≤ ${numberText(d.high.number)}${suffix}`;
  let prefix = PREFIXES[d.kind] ?? "";
  // apart from the sign before it: "⌀ ƒ 5"
  if (prefix && /^[ƒ≥≤]/.test(body)) prefix = `${prefix.trim()} `;
  const text = `${prefix}${body}${d.broken ? " ⚠" : ""}`;
  return d.derived ? `(${text})` : text;
}
