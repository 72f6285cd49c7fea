/** Dimensions as actions on the selection; the value is typed over the drawing. */

import { only, picked } from "../picked.js";

/**
 * @typedef {import("../picked.js").Picked} Picked
 *
 * @typedef {object} DimensionSpec
 * @property {string} id  word of the command
 * @property {string} title
 * @property {string} key
 * @property {string} needs  in words
 * @property {boolean} [chain]  it takes any number
 * @property {(one: Picked) => string[]} operands  empty if the selection does not fit
 * @property {(names: string[], store: import("../store.js").Store) => string} present  expression of the value that it has now, empty if there is none
 */

/** @param {boolean} fits @param {string[]} names */
const when = (fits, names) => (fits ? names : []);

/** @param {Picked} one */
function distance(one) {
  const { points, lines, rounds } = one;
  const found = [...points, ...lines, ...rounds];
  return when(found.length === 2 && only(one, points, lines, rounds), found);
}

/** @param {Picked} one */
const twoPoints = (one) => when(one.points.length === 2 && only(one, one.points), one.points);
/** @param {string} axis */
const along = (axis) => (/** @type {string[]} */ [a, b]) => `abs(${a}.${axis} - ${b}.${axis})`;

/** @type {readonly DimensionSpec[]} */
export const DIMENSIONS = [
  {
    id: "length",
    title: "Length",
    key: "Alt+L",
    needs: "a line",
    operands: (one) => when(one.lines.length === 1 && only(one, one.lines), one.lines),
    present: ([a]) => `${a}.length`,
  },
  {
    id: "distance",
    title: "Distance",
    key: "Alt+D",
    needs: "two of points, lines and circles",
    operands: distance,
    present: (names, store) => {
      const { rounds, lines } = picked(store, names);
      return rounds.length || lines.length > 1 ? "" : `dist(${names.join(", ")})`;
    },
  },
  {
    id: "hdistance",
    title: "Horizontal distance",
    key: "Alt+H",
    needs: "two points",
    operands: twoPoints,
    present: along("x"),
  },
  {
    id: "vdistance",
    title: "Vertical distance",
    key: "Alt+V",
    needs: "two points",
    operands: twoPoints,
    present: along("y"),
  },
  {
    id: "radius",
    title: "Radius",
    key: "Alt+R",
    needs: "a circle, an arc or an ellipse",
    operands: (one) => when(one.all.length === 1 && only(one, one.rounds, one.ellipses), one.all),
    present: ([a]) => `${a}.radius`,
  },
  {
    id: "diameter",
    title: "Diameter",
    key: "Alt+O",
    needs: "a circle or an arc",
    operands: (one) => when(one.all.length === 1 && only(one, one.rounds), one.rounds),
    present: ([a]) => `${a}.diameter`,
  },
  {
    id: "radius_b",
    title: "Second radius",
    key: "Alt+B",
    needs: "an ellipse",
    operands: (one) => when(one.all.length === 1 && only(one, one.ellipses), one.ellipses),
    present: ([a]) => `${a}.radius_b`,
  },
  {
    id: "angle",
    title: "Angle",
    key: "Alt+A",
    needs: "two lines",
    operands: (one) => when(one.lines.length === 2 && only(one, one.lines), one.lines),
    present: ([a, b]) => `abs(angle(${a}, ${b}))`,
  },
  {
    id: "xangle",
    title: "Angle from the x axis",
    key: "Alt+X",
    needs: "a line or an ellipse",
    operands: (one) => when(one.all.length === 1 && only(one, one.lines, one.ellipses), one.all),
    present: ([a], store) => `${a}.${store.entities.get(a)?.kind === "line" ? "angle" : "rotation"}`,
  },
  {
    id: "sweep",
    title: "Sweep",
    key: "Alt+W",
    needs: "an arc",
    operands: (one) => when(one.all.length === 1 && only(one, one.arcs), one.arcs),
    present: ([a]) => `${a}.sweep`,
  },
  {
    id: "arc_length",
    title: "Arc length",
    key: "Alt+C",
    needs: "an arc",
    operands: (one) => when(one.all.length === 1 && only(one, one.arcs), one.arcs),
    present: ([a]) => `${a}.length`,
  },
  {
    id: "total_length",
    title: "Length of a chain",
    key: "Alt+T",
    needs: "two or more curves end to end",
    chain: true,
    operands: (one) => when(one.curves.length >= 2 && only(one, one.curves), one.curves),
    present: (names) => names.map((name) => `${name}.length`).join(" + "),
  },
  {
    id: "area",
    title: "Area",
    key: "Alt+Q",
    needs: "a closed chain of curves",
    chain: true,
    operands: (one) => when(one.curves.length >= 1 && only(one, one.curves), one.curves),
    present: () => "",
  },
];
