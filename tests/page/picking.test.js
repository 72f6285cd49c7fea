/** Picking at pixels, boxes, the spatial index. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { TOLERANCE } from "../../arael/sketch/page/pick.js";
import { scene } from "./sketches.js";

const lines = () => scene([["L0", "line", [0, 0, 10, 0]], ["L1", "line", [10, 0, 10, 10]], ["L2", "line", [0, 0, 10, 0.2]]]);

const names = ({ picker, view }, x, y) => picker.all(view.toScreen([x, y])).map((pick) => pick.name);

test("points are picked before curves, the nearest first", () => {
  assert.deepEqual(names(lines(), 10, 0), ["L0.p2", "L1.p1", "L2.p2", "L0", "L1", "L2"]);
});

test("things that overlap come in the order of their distance", () => {
  assert.deepEqual(names(lines(), 5, -0.1), ["L0", "L2"]);
});

test("the tolerance is in pixels: seven for a mouse, more for touch", () => {
  const sketch = lines();
  assert.deepEqual(names(sketch, 5, -0.8), []);
  sketch.picker.tolerance = TOLERANCE.touch;
  assert.deepEqual(names(sketch, 5, -0.8), ["L0", "L2"]);
  sketch.view.scale = 100;
  assert.deepEqual(names(sketch, 5, -0.8), []);
});

test("a box from left to right takes what is inside, from right to left what it touches", () => {
  const { picker, view } = lines();
  const [a, b] = [view.toScreen([4, -1]), view.toScreen([12, 11])];
  assert.deepEqual(picker.inBox(a, b, false), ["L1"]);
  assert.deepEqual(picker.inBox(b, a, true), ["L0", "L1", "L2"]);
});

test("a box that crosses a circle's rectangle but not the circle does not touch it", () => {
  const { picker, view } = scene([["A0", "circle", [0, 0, 10]]]);
  const [a, b] = [view.toScreen([8.5, 8.5]), view.toScreen([11, 11])];
  assert.deepEqual(picker.inBox(b, a, true), []);
  assert.deepEqual(picker.inBox(view.toScreen([11, 1]), view.toScreen([9, -1]), true), ["A0"]);
});

test("what moved, came or went is picked where it is now", () => {
  const { store, picker, view } = lines();
  picker.grid;
  store.receive({
    type: "change", from: 7, revision: 8, put: { entities: [{ name: "L3", kind: "line", at: 12, size: 4 }] },
    removed: { entities: ["L2"] }, offsets: [1, 3, 12, 13, 14, 15], numbers: [5, 5, 0, -3, 10, -3],
  });
  picker.changed({ put: {}, removed: { entities: ["L2"] }, all: false });
  const sketch = { picker, view };
  assert.deepEqual(names(sketch, 5, 0), []);
  assert.deepEqual(names(sketch, 5, 5), ["L0"]);
  assert.deepEqual(names(sketch, 5, -3), ["L3"]);
});

test("at ten thousand lines a pick looks at a few", () => {
  const all = Array.from({ length: 10_000 }, (_, i) => {
    const [x, y] = [(i % 100) * 10, Math.floor(i / 100) * 10];
    return [`L${i}`, "line", [x, y, x + 8, y + 3]];
  });
  const { picker } = scene(all);
  assert.ok(picker.near([504, 501.5], 1).length <= 9);
  assert.equal(picker.near([504, 501.5], 1).filter(({ name }) => name === "L5050").length, 1);
});

test("only what moved, is new or has another place in the numbers is entered again", () => {
  const { store, picker } = scene([
    ["L0", "line", [0, 0, 10, 0]],
    ["L1", "line", [0, 20, 10, 20]],
    ["L2", "line", [0, 40, 10, 40]],
  ]);
  const grid = picker.grid;
  /** @type {string[]} */
  const entered = [];
  const put = grid.put.bind(grid);
  grid.put = (name, box) => {
    entered.push(name);
    put(name, box);
  };
  store.values[store.entities.get("L1").at] = 3;
  picker.moved();
  assert.equal(picker.grid, grid);
  assert.deepEqual(entered.splice(0), ["L1"]);
  picker.changed({ put: { entities: [store.entities.get("L2")] }, removed: {}, all: false });
  void picker.grid;
  assert.deepEqual(entered.splice(0), ["L2"]);
  picker.changed({ put: {}, removed: {}, all: false });
  void picker.grid;
  assert.deepEqual(entered, []);
});
