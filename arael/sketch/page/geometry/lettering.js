/** Texts along their frames: a line from the left end of the base line, as long as the text is wide. */

import { ABOVE, BELOW, CAPITAL, GLYPHS, SPACING, UNKNOWN } from "./font.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {{x: number, y: number, sweep: number, r: number, cx: number, cy: number, start: number}} Step
 *     to a point: straight if `r` is 0, else along an arc
 * @typedef {{width: number, strokes: Step[][]}} Glyph
 */

/** @type {Map<string, Glyph>} */
const glyphs = new Map();

/** @param {string} one @returns {Glyph} */
function glyphOf(one) {
  const known = glyphs.get(one);
  if (known) return known;
  const [width, strokes] = (Object.hasOwn(GLYPHS, one) ? GLYPHS[one] : UNKNOWN).split(":");
  const found = { width: Number(width), strokes: strokes ? strokes.split("|").map(stroke) : [] };
  glyphs.set(one, found);
  return found;
}

/** @param {string} text @returns {Step[]} */
function stroke(text) {
  if (text[0] === "@") {
    const [x, y, r] = text.slice(1).split(",").map(Number);
    return [step(x + r, y), step(x - r, y, Math.PI, [x + r, y]), step(x + r, y, Math.PI, [x - r, y])];
  }
  /** @type {Point} */
  let before = [0, 0];
  return text.split(" ").map((word) => {
    const [place, turn] = word.split("~");
    const [x, y] = place.split(",").map(Number);
    const found = step(x, y, turn ? (Number(turn) * Math.PI) / 180 : 0, before);
    before = [x, y];
    return found;
  });
}

/** The centre of an arc lies on the bisector of its chord. @param {number} x @param {number} y @param {number} [sweep] @param {Point} [from] @returns {Step} */
function step(x, y, sweep = 0, from = [0, 0]) {
  if (!sweep) return { x, y, sweep, r: 0, cx: 0, cy: 0, start: 0 };
  const [dx, dy] = [x - from[0], y - from[1]];
  const up = 0.5 / Math.tan(sweep / 2);
  const [cx, cy] = [(x + from[0]) / 2 - up * dy, (y + from[1]) / 2 + up * dx];
  const r = Math.abs((0.5 * Math.hypot(dx, dy)) / Math.sin(sweep / 2));
  return { x, y, sweep, r, cx, cy, start: Math.atan2(from[1] - cy, from[0] - cx) };
}

/** Width of a text on the grid of the font. @param {string} text */
function gridWidth(text) {
  let width = -SPACING;
  for (const one of text) width += glyphOf(one).width + SPACING;
  return width;
}

/** Width of a text whose capitals are 1 high. @param {string} text */
export const widthOf = (text) => gridWidth(text) / CAPITAL;

/** Corners of the box of a text in a frame, y upwards. @param {string} text @param {Point} a @param {Point} b @returns {Point[]} */
export function boxOfText(text, a, b) {
  const width = gridWidth(text);
  const [ux, uy] = [(b[0] - a[0]) / width, (b[1] - a[1]) / width];
  return [[0, BELOW], [width, BELOW], [width, ABOVE], [0, ABOVE]].map(([x, y]) => [a[0] + x * ux - y * uy, a[1] + x * uy + y * ux]);
}

/** Whether a point is in the box of a text. @param {string} text @param {Point} a @param {Point} b @param {Point} at */
export function isInText(text, a, b, at) {
  const width = gridWidth(text);
  const [dx, dy] = [(b[0] - a[0]) / width, (b[1] - a[1]) / width];
  const square = dx * dx + dy * dy;
  const [px, py] = [at[0] - a[0], at[1] - a[1]];
  const [x, y] = [(px * dx + py * dy) / square, (py * dx - px * dy) / square];
  return x >= 0 && x <= width && y >= BELOW && y <= ABOVE;
}

/**
 * Add the strokes of a text to a path.
 * @param {CanvasRenderingContext2D|Path2D} pen
 * @param {string} text
 * @param {Point} a  ends of the frame in pixels, y downwards
 * @param {Point} b
 */
export function traceText(pen, text, a, b) {
  const width = gridWidth(text);
  const [ux, uy] = [(b[0] - a[0]) / width, (b[1] - a[1]) / width];
  const scale = Math.hypot(ux, uy);
  const turn = Math.atan2(uy, ux);
  let [ox, oy] = a;
  for (const one of text) {
    const glyph = glyphOf(one);
    for (const steps of glyph.strokes) {
      steps.forEach(({ x, y, sweep, r, cx, cy, start }, i) => {
        const [px, py] = [ox + x * ux + y * uy, oy + x * uy - y * ux];
        if (!i) pen.moveTo(px, py);
        else if (!r) pen.lineTo(px, py);
        else pen.arc(ox + cx * ux + cy * uy, oy + cx * uy - cy * ux, r * scale, turn - start, turn - start - sweep, sweep > 0);
      });
    }
    ox += (glyph.width + SPACING) * ux;
    oy += (glyph.width + SPACING) * uy;
  }
}
