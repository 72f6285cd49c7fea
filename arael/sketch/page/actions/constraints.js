/** Constraints as actions on the selection: which selections each takes, and the command it makes. */

import { only } from "../picked.js";

/**
 * @typedef {import("../picked.js").Picked} Picked
 *
 * @typedef {object} ConstraintSpec
 * @property {string} id  word of the command
 * @property {string} title
 * @property {string} key
 * @property {string} needs  in words
 * @property {number} [most]  how many it takes, 2 if left out
 * @property {(one: Picked) => string} command  empty if the selection does not fit
 */

/**
 * @param {string} word
 * @param {string[]} names
 * @param {boolean} fits
 */
const all = (word, names, fits) => (fits ? `${word} ${names.join(" ")}` : "");

/**
 * A curve to be named with another one of a kind.
 * @param {string} word
 * @param {Picked} one
 */
const withCurve = (word, one) => {
  const fits = one.points.length === 1 && one.curves.length === 1 && only(one, one.points, one.curves);
  return fits ? `${word} ${one.points[0]} ${one.curves[0]}` : "";
};

/**
 * Two mirror images and what they mirror about, which comes to stand in the middle.
 * @param {Picked} one
 */
function symmetry(one) {
  if (!only(one, one.points, one.lines, one.rounds) || one.all.length !== 3) return "";
  const { points, lines, rounds } = one;
  if (lines.length === 1 && points.length === 2) return `symmetry ${points[0]} ${lines[0]} ${points[1]}`;
  if (lines.length === 1 && rounds.length === 2) return `symmetry ${rounds[0]} ${lines[0]} ${rounds[1]}`;
  // of three alike the last one is the axis or the middle
  if (lines.length === 3) return `symmetry ${lines[0]} ${lines[2]} ${lines[1]}`;
  if (points.length === 3) return `symmetry ${points[0]} ${points[2]} ${points[1]}`;
  return "";
}

/** @param {Picked} one */
function tangent(one) {
  const curves = [...one.lines, ...one.rounds, ...one.ellipses];
  const two = curves.length === 2 && one.lines.length < 2 && only(one, curves);
  if (two) return `tangent ${one.all.join(" ")}`;
  return all("tangent", one.points, one.points.length === 2 && only(one, one.points));
}

/**
 * @param {string} word
 * @param {Picked} one
 */
function level(word, one) {
  if (only(one, one.lines)) return `${word} ${one.lines.join(" ")}`;
  return all(word, one.points, one.points.length === 2 && only(one, one.points));
}

/** @param {Picked} one */
function coincident(one) {
  if (one.points.length < 2 || !only(one, one.points)) return "";
  const [first, ...others] = one.points;
  return others.map((other) => `coincident ${first} ${other}`).join("; ");
}

/** @param {Picked} one */
function parallel(one) {
  const { lines, ellipses } = one;
  if (lines.length >= 2 && only(one, lines)) return `parallel ${lines.join(" ")}`;
  return all("parallel", [...lines, ...ellipses], one.all.length === 2 && only(one, lines, ellipses));
}

/** @type {readonly ConstraintSpec[]} */
export const CONSTRAINTS = [
  {
    id: "coincident",
    title: "Coincident",
    key: "C",
    needs: "two or more points",
    command: coincident,
  },
  {
    id: "point_on",
    title: "Point on curve",
    key: "I",
    needs: "a point and a curve",
    command: (one) => withCurve("point_on", one),
  },
  {
    id: "midpoint",
    title: "Midpoint",
    key: "M",
    needs: "a point and a line or an arc",
    command: (one) => ([...one.lines, ...one.arcs].length === 1 ? withCurve("midpoint", one) : ""),
  },
  {
    id: "horizontal",
    title: "Horizontal",
    key: "H",
    needs: "lines, or two points",
    command: (one) => level("horizontal", one),
  },
  {
    id: "vertical",
    title: "Vertical",
    key: "V",
    needs: "lines, or two points",
    command: (one) => level("vertical", one),
  },
  {
    id: "parallel",
    title: "Parallel",
    key: "Q",
    needs: "two or more lines, or a line and an ellipse",
    command: parallel,
  },
  {
    id: "perpendicular",
    title: "Perpendicular",
    key: "N",
    needs: "two lines, or a line and an ellipse",
    command: (one) => {
      const fits = one.all.length === 2 && one.lines.length >= 1 && only(one, one.lines, one.ellipses);
      return all("perpendicular", [...one.lines, ...one.ellipses], fits);
    },
  },
  {
    id: "tangent",
    title: "Tangent",
    key: "T",
    needs: "a line and an arc, two arcs, or two ends that meet",
    command: tangent,
  },
  {
    id: "equal",
    title: "Equal",
    key: "E",
    needs: "two or more lines, or two or more circles and arcs",
    command: (one) => {
      const fits = one.all.length >= 2 && (only(one, one.lines) || only(one, one.rounds));
      return all("equal", one.all, fits);
    },
  },
  {
    id: "collinear",
    title: "Collinear",
    key: "J",
    needs: "two or more lines",
    command: (one) => all("collinear", one.lines, one.lines.length >= 2 && only(one, one.lines)),
  },
  {
    id: "concentric",
    title: "Concentric",
    key: "Shift+C",
    needs: "two or more circles, arcs or ellipses",
    command: (one) => all("concentric", one.all, one.all.length >= 2 && only(one, one.rounds, one.ellipses)),
  },
  {
    id: "symmetry",
    title: "Symmetric",
    key: "Y",
    needs: "two points or arcs and a line, or three points or lines, the axis last",
    most: 3,
    command: symmetry,
  },
  {
    id: "equal_angle",
    title: "Equal angles",
    key: "Shift+Q",
    needs: "four lines: the angle of the first two is that of the others",
    most: 4,
    command: (one) => all("equal_angle", one.lines, one.lines.length === 4 && only(one, one.lines)),
  },
  {
    id: "smooth",
    title: "Smooth",
    key: "Shift+J",
    needs: "two ends that meet",
    command: (one) => all("smooth", one.points, one.points.length === 2 && only(one, one.points)),
  },
  {
    id: "on_normal",
    title: "On normal",
    key: "Shift+N",
    needs: "a point, then the end of a curve",
    command: (one) => all("on_normal", one.points, one.points.length === 2 && only(one, one.points)),
  },
  {
    id: "lock",
    title: "Lock",
    key: "K",
    needs: "points",
    command: (one) => all("lock", one.points, only(one, one.points)),
  },
  {
    id: "unlock",
    title: "Unlock",
    key: "Shift+K",
    needs: "points",
    command: (one) => all("unlock", one.points, only(one, one.points)),
  },
  {
    id: "fix",
    title: "Fix",
    key: "Shift+F",
    needs: "entities",
    command: (one) => all("fix", one.entities, only(one, one.entities)),
  },
];
