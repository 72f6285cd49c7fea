/** What is selected, by kind, for the actions that work on it. */

import { splitHandle } from "./geometry/handles.js";

/**
 * @typedef {import("./store.js").Store} Store
 *
 * @typedef {object} Picked
 * @property {string[]} all  names and handles in the order in which they were selected
 * @property {string[]} points  handles of points, names of point entities
 * @property {string[]} lines
 * @property {string[]} rounds  circles and arcs
 * @property {string[]} arcs  of those the open ones
 * @property {string[]} ellipses  and elliptic arcs
 * @property {string[]} splines
 * @property {string[]} curves  all of the four
 * @property {string[]} entities  curves and point entities
 * @property {string[]} relations  constraints and dimensions
 * @property {string[]} dimensions
 * @property {string[]} groups
 */

/**
 * @param {Store} store
 * @param {Iterable<string>} [names]  the selection if it is left out
 * @returns {Picked}
 */
export function picked(store, names = store.selection) {
  /** @type {Picked} */
  const found = {
    all: [...names],
    points: [],
    lines: [],
    rounds: [],
    arcs: [],
    ellipses: [],
    splines: [],
    curves: [],
    entities: [],
    relations: [],
    dimensions: [],
    groups: [],
  };
  for (const name of found.all) {
    const kind = store.entities.get(name)?.kind;
    if (kind) {
      found.entities.push(name);
      if (kind === "point") found.points.push(name);
      else found.curves.push(name);
      if (kind === "line") found.lines.push(name);
      if (kind === "circle" || kind === "arc") found.rounds.push(name);
      if (kind === "arc" || kind === "earc") found.arcs.push(name);
      if (kind === "ellipse" || kind === "earc") found.ellipses.push(name);
      if (kind === "bezier" || kind === "bspline") found.splines.push(name);
    } else if (store.dimensions.has(name)) {
      found.relations.push(name);
      found.dimensions.push(name);
    } else if (store.constraints.has(name)) found.relations.push(name);
    else if (store.groups.has(name)) found.groups.push(name);
    else if (splitHandle(name)[1] && store.point(name)) found.points.push(name);
  }
  return found;
}

/**
 * Whether nothing is selected but what the lists hold.
 * @param {Picked} one
 * @param {...string[]} lists
 */
export function only(one, ...lists) {
  return one.all.length > 0 && lists.reduce((sum, list) => sum + list.length, 0) === one.all.length;
}
