/** The ten kinds of snap, and the constraints that a click would add. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { SNAP_MARKS } from "../../arael/sketch/page/draw/marks.js";
import { RANKS, WORDS } from "../../arael/sketch/page/snap/snapper.js";
import { scene } from "./sketches.js";

const point = { from: null, draws: "point" };
const from = (x, y, more = {}) => ({ from: [x, y], draws: "line", ...more });

/** The place at a point of the sketch, `dx` and `dy` pixels beside it. */
function at({ snapper, view }, x, y, context = point, dx = 0, dy = 0, options = {}) {
  const [sx, sy] = view.toScreen([x, y]);
  return snapper.place([sx + dx, sy + dy], context, options);
}

const drawing = () =>
  scene([
    ["L0", "line", [0, 0, 10, 0]],
    ["L1", "line", [5, -5, 5, 5]],
    ["A0", "circle", [-10, 0, 4]],
    ["A1", "arc", [20, 0, 23, 0, 20, 3, 3]],
  ]);

test("there are ten kinds, each with a mark and a word", () => {
  assert.equal(Object.keys(RANKS).length, 10);
  assert.deepEqual(Object.keys(SNAP_MARKS).sort(), Object.keys(RANKS).sort());
  assert.deepEqual(Object.keys(WORDS).sort(), Object.keys(RANKS).sort());
});

test("the marks of all kinds have different shapes", () => {
  const shapes = Object.values(SNAP_MARKS).map((draw) => {
    const calls = [];
    const pen = new Proxy({}, { get: (_, name) => (...args) => calls.push([name, ...args.map((n) => Math.round(n * 10))]) });
    draw(pen, 0, 0);
    return JSON.stringify(calls);
  });
  assert.equal(new Set(shapes).size, 10);
});

test("an endpoint within ten pixels is taken exactly and made coincident", () => {
  const place = at(drawing(), 10, 0, point, 6, -5);
  assert.deepEqual(place.at, [10, 0]);
  assert.equal(place.snap.kind, "endpoint");
  assert.deepEqual(place.snap.extras, ["coincident {p} L0.p2"]);
});

test("beyond ten pixels there is no endpoint", () => {
  assert.notEqual(at(drawing(), 10, 0, point, 11, 0).snap?.kind, "endpoint");
});

test("a centre", () => {
  const place = at(drawing(), -10, 0, point, 3, 3);
  assert.equal(place.snap.kind, "centre");
  assert.deepEqual(place.snap.extras, ["coincident {p} A0.center"]);
});

test("a crossing wins over the middle at the same place", () => {
  const place = at(drawing(), 5, 0, point, 2, 2);
  assert.equal(place.snap.kind, "intersection");
  assert.deepEqual(place.snap.extras.sort(), ["point_on {p} L0", "point_on {p} L1"]);
});

test("the middle of a line and of an arc", () => {
  const sketch = scene([["L0", "line", [0, 0, 10, 0]], ["A1", "arc", [20, 0, 23, 0, 20, 3, 3]]]);
  assert.deepEqual(at(sketch, 5, 0, point, 3, -3).snap.extras, ["midpoint {p} L0"]);
  const s = 3 * Math.SQRT1_2;
  assert.equal(at(sketch, 20 + s, s, point, 2, 2).snap.kind, "midpoint");
});

test("a quadrant is on the circle and level with its centre", () => {
  const place = at(drawing(), -10, 4, point, 3, 3);
  assert.equal(place.snap.kind, "quadrant");
  assert.deepEqual(place.snap.extras, ["point_on {p} A0", "vertical {p} A0.center"]);
});

test("the nearest point of a curve", () => {
  const place = at(drawing(), 2.5, 0, point, 0, 6);
  assert.equal(place.snap.kind, "nearest");
  assert.deepEqual(place.at, [2.5, 0]);
  assert.deepEqual(place.snap.extras, ["point_on {p} L0"]);
});

test("a line that is drawn snaps perpendicular to a line and tangent to a circle", () => {
  const across = at(drawing(), 2.5, 0, from(2.5, 8), 4, 4);
  assert.equal(across.snap.kind, "perpendicular");
  assert.deepEqual(across.snap.extras.slice(0, 2), ["point_on {p} L0", "perpendicular {c} L0"]);
  const half = Math.acos(4 / 10);
  const touching = at(drawing(), -10 + 4 * Math.cos(half), 4 * Math.sin(half), from(0, 0), 3, 1);
  assert.equal(touching.snap.kind, "tangent");
  assert.deepEqual(touching.snap.extras, ["point_on {p} A0", "tangent {c} A0"]);
});

test("a line that is drawn nearly level becomes horizontal", () => {
  const place = at(drawing(), 20, 20, from(0, 20), 0, 4);
  assert.equal(place.snap.kind, "alignment");
  assert.deepEqual(place.at, [20, 20]);
  assert.deepEqual(place.snap.extras, ["horizontal {c}"]);
  assert.deepEqual(place.snap.guides, [[[0, 20], [20, 20]]]);
});

test("a line goes on parallel or perpendicular to the one before", () => {
  const sketch = scene([["L0", "line", [0, 0, 4, 3]]]);
  assert.deepEqual(at(sketch, 12, 9, from(4, 3, { lines: ["L0"] }), 2, 0).snap.extras, ["parallel {c} L0"]);
  assert.deepEqual(at(sketch, 1, 7, from(4, 3, { lines: ["L0"] }), 1, 0).snap.extras, ["perpendicular {c} L0"]);
});

test("a point in line with one that was touched before", () => {
  const sketch = drawing();
  at(sketch, 10, 0);
  const place = at(sketch, 10, 20, point, 4, 0);
  assert.equal(place.snap.kind, "alignment");
  assert.equal(place.at[0], 10);
  assert.deepEqual(place.snap.extras, ["vertical {p} L0.p2"]);
});

test("the grid, if it is shown", () => {
  const sketch = drawing();
  assert.equal(at(sketch, 30, 14, point, 2, 2).snap, null);
  sketch.view.grid = true;
  const place = at(sketch, 30, 14, point, 2, 2);
  assert.equal(place.snap.kind, "grid");
  assert.deepEqual(place.at, [30, 14]);
  assert.deepEqual(place.snap.extras, []);
});

test("the key that leaves automatic constraints off keeps the place", () => {
  const place = at(drawing(), 10, 0, point, 3, 3, { bare: true });
  assert.deepEqual(place.at, [10, 0]);
  assert.deepEqual(place.snap.extras, []);
  assert.ok(place.bare);
});

test("a kind that is switched off is not taken", () => {
  const sketch = drawing();
  sketch.snapper.off.add("quadrant");
  assert.notEqual(at(sketch, -10, 4, point, 3, 3).snap.kind, "quadrant");
});

test("a free place has no more digits than pixels", () => {
  assert.deepEqual(at(drawing(), 30.123456789, 14.2).at, [30.12, 14.2]);
});
