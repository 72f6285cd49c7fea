/** Dimension lines with extension lines, arcs with arrows, leaders; the place of the text. */

import { angleOf, dot, left, mix } from "../geometry/vectors.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Dimension} Dimension
 *
 * @typedef {object} Drawn  a dimension in pixels
 * @property {string} name
 * @property {number[]} lines  x, y, x, y of each
 * @property {number[]} thin  extension lines
 * @property {[number, number, number, number, number][]} arcs  centre, radius, start and sweep on the screen
 * @property {number[]} arrows  tip and middle of the back: x, y, x, y of each
 * @property {{x: number, y: number, angle: number, text: string}} text
 * @property {number} half  half the width of the text
 * @property {(screen: Point) => {offset?: number, along?: number}} placeAt  `dim_pos` of a place of the text
 *
 * @typedef {object} Pen
 * @property {import("../store.js").Store} store
 * @property {import("../view.js").View} view
 * @property {Point} middle  of the drawing: dimension lines lie on the side away from it
 * @property {import("./places.js").Places<string>} places
 * @property {(text: string) => number} width  of a text in pixels
 */

const ARROW = 9;
const FIRST = 26;
const NEXT = 20;
const HALF_HEIGHT = 8;

/** @param {Pen} pen @param {Dimension} d @param {string} text @returns {Drawn} */
function empty(pen, d, text) {
  return {
    name: d.name, lines: [], thin: [], arcs: [], arrows: [],
    text: { x: 0, y: 0, angle: 0, text }, half: 0.5 * pen.width(text) + 3,
    placeAt: () => ({}),
  };
}

/**
 * A dimension line in a direction of the sketch between two points.
 * @param {Pen} pen @param {Dimension} d @param {string} text
 * @param {Point} a @param {Point} b @param {Point} heading
 */
export function linear(pen, d, text, a, b, heading) {
  const drawn = empty(pen, d, text);
  const { view, places } = pen;
  const n = left(heading);
  const [u, v] = [dot(a, n), dot(b, n)];
  const [s, t] = [dot(a, heading), dot(b, heading)];
  const side = dot(mix(a, b, 0.5), n) < dot(pen.middle, n) ? -1 : 1;
  const angle = angleOf(heading);
  const upright = angle > Math.PI / 2 + 1e-9 ? angle - Math.PI : angle <= -Math.PI / 2 + 1e-9 ? angle + Math.PI : angle;
  /** @type {Point} */
  const lift = [(-Math.sin(upright) * HALF_HEIGHT) / view.scale, (Math.cos(upright) * HALF_HEIGHT) / view.scale];
  /** @param {number} level @param {number} slide @returns {Point} */
  const textAt = (level, slide) => {
    const along = 0.5 * (s + t) + slide * (t - s);
    return view.toScreen([along * heading[0] + level * n[0] + lift[0], along * heading[1] + level * n[1] + lift[1]]);
  };
  const levels = typeof d.offset === "number" ? [0.5 * (u + v) + d.offset] : automaticLevels(u, v, side, view.scale);
  const slides = typeof d.along === "number" ? [d.along] : [0, 0.2, -0.2];
  const w = Math.abs(Math.cos(upright)) * drawn.half + Math.abs(Math.sin(upright)) * HALF_HEIGHT;
  const h = Math.abs(Math.sin(upright)) * drawn.half + Math.abs(Math.cos(upright)) * HALF_HEIGHT;
  /** @param {number} level @returns {[Point, Point]} */
  const lineAt = (level) => [
    view.toScreen([s * heading[0] + level * n[0], s * heading[1] + level * n[1]]),
    view.toScreen([t * heading[0] + level * n[0], t * heading[1] + level * n[1]]),
  ];
  const [level, at] = firstFree(slides, levels, textAt, (p, one) => places.isFree(p[0], p[1], w, h, () => lineAt(one)));
  places.take(at[0], at[1], w, h, d.name);
  const [p, q] = lineAt(level);
  extension(drawn, view.toScreen(a), p);
  extension(drawn, view.toScreen(b), q);
  arrowed(drawn, p, q);
  places.takeLines(drawn.thin);
  places.takeLines([p[0], p[1], q[0], q[1]]);
  drawn.text = { x: at[0], y: at[1], angle: -upright, text };
  drawn.placeAt = (screen) => {
    const [x, y] = view.toWorld(screen);
    const offset = (x - lift[0]) * n[0] + (y - lift[1]) * n[1] - 0.5 * (u + v);
    const along = t === s ? 0 : ((x - lift[0]) * heading[0] + (y - lift[1]) * heading[1] - 0.5 * (s + t)) / (t - s);
    return { offset, along: Math.abs(along) < 0.04 ? 0 : Math.min(Math.max(along, -0.5), 0.5) };
  };
  return drawn;
}

/**
 * The first level and place that are free, in the order of slides and then levels; the first of all if none is.
 * @param {number[]} slides @param {number[]} levels
 * @param {(level: number, slide: number) => Point} place @param {(at: Point, level: number) => boolean} isFree
 * @returns {[number, Point]}
 */
function firstFree(slides, levels, place, isFree) {
  for (const slide of slides) {
    for (const level of levels) {
      const at = place(level, slide);
      if (isFree(at, level)) return [level, at];
    }
  }
  return [levels[0], place(levels[0], slides[0])];
}

/** @param {number} u @param {number} v @param {number} side @param {number} scale */
function automaticLevels(u, v, side, scale) {
  const levels = [];
  for (const s of [side, -side]) {
    for (let k = 0; k < 4; k++) levels.push((s > 0 ? Math.max(u, v) : Math.min(u, v)) + (s * (FIRST + k * NEXT)) / scale);
  }
  return levels;
}

/** @param {Drawn} drawn @param {Point} from @param {Point} to */
function extension(drawn, from, to) {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length <= 6) return;
  const x = (4 * (to[0] - from[0])) / length;
  const y = (4 * (to[1] - from[1])) / length;
  drawn.thin.push(from[0] + x, from[1] + y, to[0] + x, to[1] + y);
}

/** @param {Drawn} drawn @param {Point} p @param {Point} q */
function arrowed(drawn, p, q) {
  const length = Math.hypot(q[0] - p[0], q[1] - p[1]);
  if (length < 1e-6) return;
  const inside = length >= 3 * ARROW;
  const x = (inside ? 1 : -1) * (q[0] - p[0]) / length;
  const y = (inside ? 1 : -1) * (q[1] - p[1]) / length;
  const out = inside ? 0 : 2 * ARROW;
  drawn.lines = [p[0] + out * x, p[1] + out * y, q[0] - out * x, q[1] - out * y];
  arrow(drawn, p, -x, -y);
  arrow(drawn, q, x, y);
}

/** @param {Drawn} drawn @param {Point} tip @param {number} x @param {number} y  direction */
export function arrow({ arrows }, [tx, ty], x, y) {
  arrows.push(tx, ty, tx - ARROW * x, ty - ARROW * y);
}

/**
 * An arc with arrows; angles as in the sketch, the radius in pixels.
 * @param {Pen} pen @param {Dimension} d @param {string} text
 * @param {Point} centre @param {number} start @param {number} sweep @param {number} radius
 */
export function angular(pen, d, text, centre, start, sweep, radius) {
  const drawn = empty(pen, d, text);
  const [cx, cy] = pen.view.toScreen(centre);
  const { half } = drawn;
  const middle = start + sweep * (0.5 + (d.along ?? 0));
  const radii = typeof d.offset === "number" ? [radius] : [0, 1, 2, 3, 4].map((k) => radius + k * NEXT);
  /** @param {number} r @returns {Point} */
  const textAt = (r) => {
    const out = r + 4 + Math.abs(Math.cos(middle)) * half + Math.abs(Math.sin(middle)) * HALF_HEIGHT;
    return [cx + out * Math.cos(middle), cy - out * Math.sin(middle)];
  };
  const r = radii.find((one) => pen.places.isFree(...textAt(one), half, HALF_HEIGHT)) ?? radius;
  const [x, y] = textAt(r);
  pen.places.take(x, y, half, HALF_HEIGHT, d.name);
  drawn.arcs.push([cx, cy, r, -start, -sweep]);
  if (Math.abs(sweep) * r > 2.5 * ARROW) {
    const turn = sweep > 0 ? 1 : -1;
    // arrows lie on the chord of their own length, not on the tangent
    const bend = (0.5 * ARROW) / r;
    for (const [angle, sign] of [[start, -turn], [start + sweep, turn]]) {
      const inner = angle - sign * bend;
      arrow(drawn, [cx + r * Math.cos(angle), cy - r * Math.sin(angle)], -sign * Math.sin(inner), -sign * Math.cos(inner));
    }
  }
  drawn.text = { x, y, angle: 0, text };
  return drawn;
}

/**
 * An arrow at a tip from outside, the text at its end; pixels.
 * @param {Pen} pen @param {Dimension} d @param {string} text
 * @param {Point} tip @param {Point} heading @param {Point} tail
 */
export function leader(pen, d, text, tip, heading, tail) {
  const drawn = empty(pen, d, text);
  const { half } = drawn;
  const lengths =
    typeof d.offset === "number" ? [Math.abs(d.offset) * pen.view.scale] : [0, 1, 2, 3, 4].map((k) => 24 + k * NEXT);
  /** @param {number} length @returns {Point} */
  const textAt = (length) => {
    const x = tip[0] + length * heading[0];
    return [x + (heading[0] >= 0 ? half : -half), tip[1] + length * heading[1]];
  };
  const length = lengths.find((one) => pen.places.isFree(...textAt(one), half, HALF_HEIGHT)) ?? lengths[0];
  const [x, y] = textAt(length);
  pen.places.take(x, y, half, HALF_HEIGHT, d.name);
  /** @type {Point} */
  const end = [tip[0] + length * heading[0], tip[1] + length * heading[1]];
  drawn.lines.push(...tail, ...end);
  pen.places.takeLines(drawn.lines);
  arrow(drawn, tip, -heading[0], -heading[1]);
  drawn.text = { x, y, angle: 0, text };
  return drawn;
}

/**
 * Text alone, around a point in pixels.
 * @param {Pen} pen @param {Dimension} d @param {string} text @param {Point} at
 */
export function note(pen, d, text, at) {
  const drawn = empty(pen, d, text);
  /** @type {Point[]} */
  const spots = [0, -1, 1, -2, 2, -3].map((k) => [at[0], at[1] + 18 * k]);
  const [x, y] = pen.places.firstFree(spots, drawn.half, HALF_HEIGHT);
  pen.places.take(x, y, drawn.half, HALF_HEIGHT, d.name);
  drawn.text = { x, y, angle: 0, text };
  return drawn;
}
