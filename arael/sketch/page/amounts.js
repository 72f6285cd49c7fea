/** Values of dimensions as they are typed. */

/** @typedef {import("./types.js").Dimension} Dimension */

/**
 * A number as it is shown: at most six digits, no zeros at the end.
 * @param {number} value
 */
export function shown(value) {
  if (!Number.isFinite(value)) return String(value);
  const text = Number(value.toPrecision(6));
  return Object.is(text, -0) ? "0" : String(text);
}

/**
 * The text of a dimension's value, as it would be typed.
 * @param {Dimension} record
 */
export function amountText(record) {
  const { value, low, high } = record;
  if (low && high) return `${low.text} to ${high.text}`;
  if (low) return `>= ${low.text}`;
  if (high) return `<= ${high.text}`;
  return value?.text ?? "";
}
