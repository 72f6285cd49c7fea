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

/** What a dimension measures. @param {string} kind @returns {import("../lengths.js").Quantity} */
export const quantityOf = (kind) => (kind === "area" ? "area" : ANGLES.has(kind) ? "angle" : "length");

/** Whether the value of a dimension is an expression that it follows. @param {Dimension} d */
export const isExpression = (d) => !d.derived && !!d.value && !LITERAL.test(d.value.text);

/**
 * What the drawing shows: value or range with its sign and unit; derived ones in parentheses.
 * @param {Dimension} d
 * @param {import("../lengths.js").Lengths} lengths
 * @param {number|null} [measured]  value of a derived dimension now
 */
export function dimensionText(d, lengths, measured = null) {
  const quantity = quantityOf(d.kind);
  const suffix = { angle: "°", area: ` ${lengths.name}²`, length: lengths.other ? ` ${lengths.name}` : "" }[quantity];
  const text = (/** @type {number} */ number) => `${numberText(lengths.number(number, quantity))}${suffix}`;
  let body = "";
  if (d.value) {
    const number = d.derived && measured !== null ? measured : d.value.number;
    body = `${isExpression(d) ? "ƒ " : ""}${text(number)}`;
  } else if (d.low && d.high) body = `${text(d.low.number)} … ${text(d.high.number)}`;
  else if (d.low) body = `≥ ${text(d.low.number)}`;
  else if (d.high) body = `≤ ${text(d.high.number)}`;
  let prefix = PREFIXES[d.kind] ?? "";
  // apart from the sign before it: "⌀ ƒ 5"
  if (prefix && /^[ƒ≥≤]/.test(body)) prefix = `${prefix.trim()} `;
  const whole = `${prefix}${body}${d.broken ? " ⚠" : ""}`;
  return d.derived ? `(${whole})` : whole;
}
