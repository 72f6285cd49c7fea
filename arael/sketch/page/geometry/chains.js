/** Chains: curves that are connected by coincident points. */

import { splitHandle } from "./handles.js";

/**
 * Curves that are connected to one, itself included.
 * @param {import("../store.js").Store} store
 * @param {string} name
 * @returns {string[]}
 */
export function chainOf(store, name) {
  /** @type {Map<string, string[]>} */
  const neighbours = new Map();
  for (const { kind, args } of store.constraints.values()) {
    if (kind !== "coincident") continue;
    const [a, b] = args.map((handle) => splitHandle(handle)[0]);
    neighbours.set(a, [...(neighbours.get(a) ?? []), b]);
    neighbours.set(b, [...(neighbours.get(b) ?? []), a]);
  }
  const found = new Set([name]);
  for (const one of found) for (const other of neighbours.get(one) ?? []) found.add(other);
  return [...found];
}
