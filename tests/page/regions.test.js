/** Regions: faces between curves, holes, open ends; areas against formulas. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { regionAt, regionsOf } from "../../arael/sketch/page/geometry/regions.js";
import { stored } from "./sketches.js";

const RECTANGLE = [
  ["L0", "line", [0, 0, 10, 0]], ["L1", "line", [10, 6, 10, 0]], ["L2", "line", [10, 6, 0, 6]], ["L3", "line", [0, 6, 0, 0]],
];
const CIRCLE = ["A0", "circle", [3, 3, 2]];
const near = (/** @type {number} */ found, /** @type {number} */ expected) =>
  assert.ok(Math.abs(found - expected) <= 1e-6 * Math.abs(expected), `${found} instead of ${expected}`);
const found = (entities) => regionsOf(stored(entities));

test("a plate with a hole: the hole is outside, and counts to the perimeter", () => {
  const { loops, openEnds } = found([...RECTANGLE, CIRCLE]);
  assert.equal(loops.length, 2);
  assert.deepEqual(openEnds, []);
  const plate = regionAt(loops, [8, 1]);
  near(plate.area, 60 - 4 * Math.PI);
  near(plate.perimeter, 32 + 4 * Math.PI);
  assert.equal(regionAt(loops, [3, 3]), null);
  assert.equal(regionAt(loops, [11, 3]), null);
});

test("what lies in a hole is a region again", () => {
  const { loops } = found([...RECTANGLE, CIRCLE, ["A1", "circle", [3, 3, 0.5]]]);
  near(regionAt(loops, [3, 3]).area, 0.25 * Math.PI);
  near(regionAt(loops, [8, 1]).area, 60 - 4 * Math.PI);
});

test("a wall between corners makes two faces", () => {
  const { loops } = found([...RECTANGLE, ["L4", "line", [0, 0, 10, 6]]]);
  assert.deepEqual(loops.map(({ area }) => Math.round(1e6 * area) / 1e6), [30, 30]);
  near(regionAt(loops, [8, 1]).perimeter, 16 + Math.hypot(10, 6));
});

test("a wall that ends on two sides divides, and so does a crossing", () => {
  const wall = found([...RECTANGLE, ["L4", "line", [4, 0, 4, 6]]]).loops;
  near(regionAt(wall, [1, 1]).area, 24);
  near(regionAt(wall, [8, 1]).area, 36);
  const cross = found([...RECTANGLE, ["L4", "line", [4, -1, 4, 7]], ["L5", "line", [-1, 2, 11, 2]]]);
  assert.deepEqual(cross.loops.map(({ area }) => Math.round(area)).sort((a, b) => a - b), [8, 12, 16, 24]);
});

test("two circles that overlap: a lens between two moons; a chord", () => {
  const { loops } = found([["A0", "circle", [0, 0, 2]], ["A1", "circle", [2, 0, 2]]]);
  const lens = 8 * (Math.PI / 3 - Math.sqrt(3) / 4);
  near(regionAt(loops, [1, 0]).area, lens);
  near(regionAt(loops, [-1, 0]).area, 4 * Math.PI - lens);
  const chord = found([["A0", "circle", [0, 0, 2]], ["L0", "line", [0, -3, 0, 3]]]).loops;
  near(regionAt(chord, [1, 0]).area, 2 * Math.PI);
  near(regionAt(chord, [1, 0]).perimeter, 2 * Math.PI + 4);
});

test("an arc on two lines, whichever way they run", () => {
  const slot = (/** @type {number[]} */ one, /** @type {number[]} */ other) => [
    ["L0", "line", one], ["L1", "line", other],
    ["A0", "arc", [0, 1, 0, 2, 0, 0, 1]], ["A1", "arc", [5, 1, 5, 0, 5, 2, 1]],
  ];
  for (const lines of [slot([0, 0, 5, 0], [0, 2, 5, 2]), slot([5, 0, 0, 0], [5, 2, 0, 2])]) {
    const { loops } = found(lines);
    assert.equal(loops.length, 1);
    near(loops[0].area, 10 + Math.PI);
    near(loops[0].length, 10 + 2 * Math.PI);
  }
});

test("ends that meet nothing are open, of chains alone", () => {
  const gap = found(RECTANGLE.map(([name, kind, numbers]) => [name, kind, name === "L3" ? [0, 5.9, 0, 0] : numbers]));
  assert.equal(gap.loops.length, 0);
  assert.deepEqual(gap.openEnds.sort(), [[0, 5.9], [0, 6]]);
  assert.deepEqual(found([["L0", "line", [0, 0, 1, 0]]]).openEnds, []);
});

test("a spur, construction, texts and points bound nothing", () => {
  const { loops, openEnds } = found([
    ...RECTANGLE, ["L4", "line", [10, 6, 12, 9]], ["L5", "line", [0, 0, 10, 6], { construction: true }],
    ["L6", "line", [0, 0, 10, 6], { text: "a" }], ["P0", "point", [5, 5]],
  ]);
  assert.equal(loops.length, 1);
  near(loops[0].length, 32);
  assert.deepEqual(openEnds, [[12, 9]]);
});

test("a sketch of many disjoint chains, far from the origin", () => {
  const squares = Array.from({ length: 100 }, (_, k) =>
    RECTANGLE.map(([name, kind, [x1, y1, x2, y2]]) => [`${name}0${k}`, kind, [x1 + 20 * k + 1e4, y1 + 1e4, x2 + 20 * k + 1e4, y2 + 1e4]]));
  const { loops } = found(squares.flat());
  assert.equal(loops.length, 100);
  for (const { area } of loops) near(area, 60);
});
