/** Handles: the texts that name entities and their points. */

/** @typedef {import("../types.js").Entity} Entity */

/** Offsets of named points within the numbers of an entity; splines have poles instead. */
export const POINTS = {
  point: { pos: 0 },
  line: { p1: 0, p2: 2 },
  circle: { center: 0 },
  arc: { center: 0, start: 2, end: 4 },
  ellipse: { center: 0 },
  earc: { center: 0, start: 2, end: 4 },
};

/**
 * Name and point of a handle; the point is empty for an entity itself.
 * @param {string} handle
 * @returns {[string, string]}
 */
export function splitHandle(handle) {
  const dot = handle.indexOf(".");
  return dot < 0 ? [handle, ""] : [handle.slice(0, dot), handle.slice(dot + 1)];
}

/**
 * Offset of a point's x in the numbers of the document, -1 if the entity has no such point.
 * @param {Entity} entity
 * @param {string} point  empty for a point entity
 */
export function pointOffset(entity, point) {
  if (entity.kind === "point") return point === "" || point === "pos" ? entity.at : -1;
  if (entity.kind === "bezier" || entity.kind === "bspline") {
    const count = entity.size / 2;
    const index =
      point === "p1" ? 0 : point === "p2" ? count - 1 : point.startsWith("pole") ? Number(point.slice(4)) - 1 : -1;
    return Number.isInteger(index) && index >= 0 && index < count ? entity.at + 2 * index : -1;
  }
  let wanted = point;
  if (entity.clockwise && (point === "start" || point === "end")) wanted = point === "start" ? "end" : "start";
  const offset = /** @type {Record<string, number>} */ (POINTS[entity.kind])[wanted];
  return offset === undefined ? -1 : entity.at + offset;
}

/**
 * Handles of all points of an entity.
 * @param {Entity} entity
 * @returns {string[]}
 */
export function pointHandles(entity) {
  if (entity.kind === "point") return [entity.name];
  if (entity.kind === "bezier" || entity.kind === "bspline") {
    const count = entity.size / 2;
    return Array.from({ length: count }, (_, i) => {
      const name = i === 0 ? "p1" : i === count - 1 ? "p2" : `pole${i + 1}`;
      return `${entity.name}.${name}`;
    });
  }
  return Object.keys(POINTS[entity.kind]).map((point) => `${entity.name}.${point}`);
}

/**
 * Names of the points where a curve begins and ends.
 * @param {Entity} entity
 * @returns {string[]}
 */
export function endNames(entity) {
  if (entity.kind === "arc" || entity.kind === "earc") return ["start", "end"];
  return ["line", "bezier", "bspline"].includes(entity.kind) ? ["p1", "p2"] : [];
}
