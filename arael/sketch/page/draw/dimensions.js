/** Dimensions as lines, arrows, arcs and a text, in pixels; one shape for every kind. */

import { angleAt, conicPoint } from "../geometry/conics.js";
import { boundsOf, curveOf, lineEnds, pointAt } from "../geometry/curves.js";
import { joined } from "../geometry/boxes.js";
import { meet } from "../geometry/intersect.js";
import { angleOf, cross, dist, dot, foot, mix, polar, signed, sub, unit } from "../geometry/vectors.js";
import { angular, arrow, leader, linear, note } from "./lines.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Conic} Conic
 * @typedef {import("../types.js").Dimension} Dimension
 * @typedef {import("./lines.js").Drawn} Drawn
 * @typedef {import("./lines.js").Pen} Pen
 */

/**
 * Layout of one dimension; null if its geometry is not there.
 * @param {Pen} pen
 * @param {Dimension} d
 * @param {string} text
 * @returns {Drawn|null}
 */
export function layoutDimension(pen, d, text) {
  return SHAPES[d.kind]?.(pen, d, text) ?? null;
}

/** @param {Pen} pen @param {string} name */
function curve(pen, name) {
  const entity = pen.store.entities.get(name);
  return entity ? curveOf(entity, pen.store.values) : null;
}

/** @param {Pen} pen @param {string} name @returns {Conic|null} */
function conic(pen, name) {
  const found = curve(pen, name);
  return found?.type === "conic" ? found : null;
}

/** @param {Pen} pen @param {string} name @returns {[Point, Point]|null} */
function ends(pen, name) {
  const found = curve(pen, name);
  return found?.type === "line" ? lineEnds(found) : null;
}

/** @param {Pen} pen @param {Dimension} d @param {string} text @param {Point} a @param {Point} b */
const aligned = (pen, d, text, a, b) => linear(pen, d, text, a, b, unit(sub(b, a)));

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function length(pen, d, text) {
  const line = ends(pen, d.args[0]);
  return line && aligned(pen, d, text, ...line);
}

/** @param {Conic} c @returns {Point} */
const middle = (c) => [c.cx, c.cy];

/** On a whole circle, towards a point. @param {Conic} c @param {Point} p */
const rim = (c, p) => conicPoint(c, angleOf(sub(p, middle(c))) - c.turn);

/** @typedef {import("../types.js").Curve|null} Carrier */

/**
 * Where a distance begins and ends, by the curves or points that it is between.
 * @param {Dimension} d @param {Carrier} one @param {Carrier} two @param {Point|null} p @param {Point|null} q
 * @returns {[Point, Point]|null}
 */
function span(d, one, two, p, q) {
  const round = two?.type === "conic";
  if (!round && two?.type !== "line") return p && q && [p, q];
  if (round && one?.type === "conic") {
    if (one.rx < two.rx) return span(d, two, one, q, p);
    const angle = Math.PI / 4 + (d.along ?? 0) * 2 * Math.PI;
    const a = d.mode ? rim(one, middle(two)) : conicPoint(one, angle - one.turn);
    return [a, rim(two, d.mode === "outside" ? middle(one) : a)];
  }
  const a = one?.type !== "line" ? p : round ? foot(middle(two), ...lineEnds(one)) : pointAt(one, 0.5);
  return a && [a, round ? rim(two, a) : foot(a, ...lineEnds(two))];
}

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function distance(pen, d, text) {
  const [one, two] = d.args.map((arg) => curve(pen, arg));
  const found = span(d, one, two, pen.store.point(d.args[0]), pen.store.point(d.args[1]));
  return found && aligned(pen, d, text, ...found);
}

/** @param {0|1} axis @returns {(pen: Pen, d: Dimension, text: string) => Drawn|null} */
function along(axis) {
  return (pen, d, text) => {
    const a = pen.store.point(d.args[0]);
    const b = pen.store.point(d.args[1]);
    if (!a || !b) return null;
    const [p, q] = a[axis] <= b[axis] ? [a, b] : [b, a];
    return linear(pen, d, text, p, q, axis === 0 ? [1, 0] : [0, 1]);
  };
}

/** Angle of a radial dimension's arrow. @param {Conic} c @param {Dimension} d */
function radialAngle(c, d) {
  if (d.kind === "radius_b") return Math.PI / 2;
  if (c.rx !== c.ry) return 0;
  if (c.closed) return Math.PI / 4 + (d.along ?? 0) * 2 * Math.PI - c.turn;
  return c.start + c.sweep * (0.5 + (d.along ?? 0));
}

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function radial(pen, d, text) {
  const c = conic(pen, d.args[0]);
  if (!c) return null;
  const angle = radialAngle(c, d);
  const tip = pen.view.toScreen(conicPoint(c, angle));
  const centre = pen.view.toScreen([c.cx, c.cy]);
  const opposite = pen.view.toScreen(conicPoint(c, angle + Math.PI));
  const drawn = leader(pen, d, text, tip, unit(sub(tip, centre)), d.kind === "diameter" ? opposite : centre);
  if (d.kind === "diameter") arrow(drawn, opposite, ...unit(sub(opposite, centre)));
  drawn.placeAt = (screen) => {
    const p = pen.view.toWorld(screen);
    const out = dist(p, [c.cx, c.cy]) - dist(conicPoint(c, angle), [c.cx, c.cy]);
    const offset = Math.max(Math.abs(out) - (drawn.half + 2) / pen.view.scale, 10 / pen.view.scale);
    if (c.rx !== c.ry) return { offset };
    const at = angleAt(c, p);
    const turns = c.closed
      ? signed(at + c.turn - Math.PI / 4) / (2 * Math.PI)
      : signed(at - c.start - 0.5 * c.sweep) / c.sweep;
    return { offset, along: Math.min(Math.max(turns, -0.5), 0.5) };
  };
  return drawn;
}

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function sweep(pen, d, text) {
  const c = conic(pen, d.args[0]);
  if (!c) return null;
  const s = pen.view.scale;
  const away = typeof d.offset === "number" ? d.offset * s : 20;
  const radius = Math.max(c.rx * s + away, 4);
  const drawn = angular(pen, d, text, [c.cx, c.cy], c.start + c.turn, c.sweep, radius);
  for (const angle of [c.start, c.start + c.sweep]) {
    const edge = pen.view.toScreen(conicPoint(c, angle));
    const u = unit(sub(edge, pen.view.toScreen([c.cx, c.cy])));
    const far = away + 4;
    drawn.thin.push(edge[0] + 4 * u[0], edge[1] + 4 * u[1], edge[0] + far * u[0], edge[1] + far * u[1]);
  }
  drawn.placeAt = placedRound(pen, [c.cx, c.cy], c.start + c.turn, c.sweep, c.rx);
  return drawn;
}

/** @param {Pen} pen @param {Point} centre @param {number} start @param {number} sweep @param {number} from */
function placedRound(pen, centre, start, sweep, from) {
  return (/** @type {Point} */ screen) => {
    const v = sub(pen.view.toWorld(screen), centre);
    const turns = sweep ? signed(angleOf(v) - start - 0.5 * sweep) / sweep : 0;
    const offset = Math.max(Math.hypot(...v) - 14 / pen.view.scale, 8 / pen.view.scale) - from;
    return { offset, along: Math.min(Math.max(turns, -0.5), 0.5) };
  };
}

/** @param {Pen} pen @param {Dimension} d @param {number} far  reach of the lines */
function arcRadius(pen, d, far) {
  if (typeof d.offset === "number") return Math.max(Math.abs(d.offset) * pen.view.scale, 6);
  return Math.max(Math.min(0.5 * far * pen.view.scale, 54), 22);
}

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function angle(pen, d, text) {
  const a = ends(pen, d.args[0]);
  const b = ends(pen, d.args[1]);
  if (!a || !b) return null;
  const vertex = meet(...a, ...b);
  if (!vertex) return note(pen, d, text, pen.view.toScreen(mix(...a, 0.5)));
  const [u, v] = [sub(a[1], a[0]), sub(b[1], b[0])];
  let start = angleOf(u);
  let turn = Math.atan2(cross(u, v), dot(u, v));
  if (d.mode === "supplement") turn += turn > 0 ? -Math.PI : Math.PI;
  // of the two opposite sectors the one in which the lines lie
  const bisector = polar(start + 0.5 * turn);
  const reach = [...a, ...b].reduce((sum, p) => sum + dot(sub(p, vertex), bisector), 0);
  if (reach < 0) start += Math.PI;
  const far = Math.min(...[a, b].map((line) => Math.max(...line.map((p) => dist(p, vertex)))));
  const drawn = angular(pen, d, text, vertex, start, turn, arcRadius(pen, d, far));
  drawn.placeAt = placedRound(pen, vertex, start, turn, 0);
  return drawn;
}

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function xangle(pen, d, text) {
  const c = curve(pen, d.args[0]);
  if (!c || c.type === "spline") return null;
  /** @type {Point} */
  const at = c.type === "line" ? [c.x1, c.y1] : [c.cx, c.cy];
  const turn = c.type === "line" ? Math.atan2(c.y2 - c.y1, c.x2 - c.x1) : signed(c.turn);
  const far = c.type === "line" ? Math.hypot(c.x2 - c.x1, c.y2 - c.y1) : Math.max(c.rx, c.ry);
  const radius = arcRadius(pen, d, far);
  const drawn = angular(pen, d, text, at, 0, turn, radius);
  const [x, y] = pen.view.toScreen(at);
  drawn.thin.push(x, y, x + radius + 14, y);
  drawn.placeAt = placedRound(pen, at, 0, turn, 0);
  return drawn;
}

/** @param {Pen} pen @param {Dimension} d @param {string} text */
function total(pen, d, text) {
  const curves = d.args.map((arg) => curve(pen, arg)).filter((c) => c !== null);
  if (!curves.length) return null;
  if (d.kind === "total_length") {
    const [x, y] = pen.view.toScreen(pointAt(curves[Math.floor(curves.length / 2)], 0.5));
    return note(pen, d, text, [x, y - 14]);
  }
  const box = curves.map(boundsOf).reduce(joined);
  return note(pen, d, text, pen.view.toScreen([0.5 * (box.xmin + box.xmax), 0.5 * (box.ymin + box.ymax)]));
}

/** @type {Record<string, (pen: Pen, d: Dimension, text: string) => Drawn|null>} */
const SHAPES = {
  length,
  distance,
  hdistance: along(0),
  vdistance: along(1),
  radius: radial,
  radius_b: radial,
  diameter: radial,
  sweep,
  arc_length: sweep,
  angle,
  xangle,
  total_length: total,
  area: total,
};

const degrees = (/** @type {number} */ angle) => (angle * 180) / Math.PI;

/** @param {import("../types.js").Line} line */
const headingOf = ({ x1, y1, x2, y2 }) => /** @type {Point} */ ([x2 - x1, y2 - y1]);

/** Degrees from one line to the other, as `measures.py` has it. @param {import("../types.js").Line} a @param {import("../types.js").Line} b @param {string} [mode] */
function angleBetween(a, b, mode) {
  const [u, v] = [headingOf(a), headingOf(b)];
  const angle = degrees(Math.atan2(cross(u, v), dot(u, v)));
  if (mode !== "supplement") return angle;
  return (180 - Math.abs(angle)) * (angle < 0 ? 1 : angle > 0 ? -1 : 1);
}

/**
 * Present value of a dimension's quantity, for derived ones and while dragging; null if it is not measured here.
 * @param {import("../store.js").Store} store
 * @param {Dimension} d
 * @returns {number|null}
 */
export function measured(store, d) {
  const [a, b] = d.args.map((arg) => {
    const entity = store.entities.get(arg);
    return entity ? curveOf(entity, store.values) : null;
  });
  const [p, q] = d.args.map((arg) => store.point(arg));
  if (d.kind === "length" && a?.type === "line") return dist(...lineEnds(a));
  if (d.kind === "angle" && a?.type === "line" && b?.type === "line") return angleBetween(a, b, d.mode);
  if (d.kind === "xangle" && a && a.type !== "spline") return degrees(a.type === "line" ? angleOf(headingOf(a)) : signed(a.turn));
  if (d.kind === "hdistance" && p && q) return Math.abs(q[0] - p[0]);
  if (d.kind === "vdistance" && p && q) return Math.abs(q[1] - p[1]);
  const found = d.kind === "distance" && span(d, a, b, p, q);
  if (found) return dist(...found);
  if (a?.type === "conic") {
    if (d.kind === "radius") return a.rx;
    if (d.kind === "diameter") return 2 * a.rx;
    if (d.kind === "radius_b") return a.ry;
    if (d.kind === "sweep") return degrees(Math.abs(a.sweep));
    if (d.kind === "arc_length") return a.rx * Math.abs(a.sweep);
  }
  return null;
}

