/** What is cleared of a canvas: all that was drawn, and little besides. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { Batches } from "../../arael/sketch/page/draw/batches.js";
import { Swept } from "../../arael/sketch/page/draw/swept.js";
import { View } from "../../arael/sketch/page/view.js";
import { stored } from "./sketches.js";

const [WIDTH, HEIGHT] = [935, 697];

/** Rectangles that are cleared. @param {Swept} swept */
function cleared(swept) {
  /** @type {number[][]} */
  const found = [];
  swept.clear(/** @type {any} */ ({ clearRect: (...given) => found.push(given) }));
  return found;
}

/** Whether a square around a place is cleared. @param {number[][]} rects */
const covers = (rects, x, y, half) =>
  [[x - half, y - half], [x + half, y - half], [x - half, y + half], [x + half, y + half]]
    .filter(([px, py]) => px >= 0 && py >= 0 && px < WIDTH && py < HEIGHT)
    .every(([px, py]) => rects.some(([l, t, w, h]) => px >= l && px <= l + w && py >= t && py <= t + h));

test("a line is cleared with what its pen and marks reach, a diagonal chain by thin strips", () => {
  const swept = new Swept();
  swept.begin(WIDTH, HEIGHT);
  assert.deepEqual(cleared(swept), []);
  const places = Array.from({ length: 91 }, (_, i) => [10 * i, 20 + 7 * i]);
  places.slice(1).forEach(([x, y], i) => swept.add(...places[i], x, y));
  const rects = cleared(swept);
  for (const [x, y] of places) assert.ok(covers(rects, x, y, 10), `${x}, ${y}`);
  const area = rects.reduce((sum, [, , w, h]) => sum + w * h, 0);
  assert.ok(area < 0.15 * WIDTH * HEIGHT, `${area}`);
});

test("what begins anew is clear, and what is outside or nowhere does no harm", () => {
  const swept = new Swept();
  swept.begin(WIDTH, HEIGHT);
  swept.add(-500, -500, 2000, 2000);
  assert.ok(covers(cleared(swept), 467, 348, 300));
  swept.begin(WIDTH, HEIGHT);
  swept.begin(WIDTH, HEIGHT);
  swept.add(NaN, 5, 9, NaN);
  swept.add(-900, 5, -100, 9);
  swept.add(5, -900, 9, -100);
  assert.deepEqual(cleared(swept), []);
  swept.addAll();
  assert.ok(covers(cleared(swept), WIDTH / 2, HEIGHT / 2, 340));
  swept.begin(300, 200);
  swept.addAll();
  for (const [, top, , height] of cleared(swept)) assert.deepEqual([top, height], [0, 200]);
});

test("what the drawing before covered is cleared with this one's, by pixels of the screen", () => {
  const swept = new Swept();
  swept.begin(WIDTH, HEIGHT, 1.5);
  swept.add(100, 200, 110, 210);
  swept.begin(WIDTH, HEIGHT, 1.5);
  swept.add(600, 400, 610, 690);
  const rects = cleared(swept);
  for (const [x, y] of [[105, 205], [605, 550]]) {
    assert.ok(rects.some(([l, t, w, h]) => 1.5 * x - 8 >= l && 1.5 * x + 8 <= l + w && 1.5 * y - 15 >= t && 1.5 * y + 15 <= t + h));
  }
  assert.ok(rects.every((rect) => rect.every(Number.isInteger)));
  assert.equal(Math.max(...rects.map(([, t, , h]) => t + h)), Math.round(1.5 * HEIGHT));
  swept.begin(300, 200);
  assert.deepEqual(cleared(swept), []);
});

test("batches give every place at which they draw", () => {
  const store = stored([
    ["L0", "line", [0, 0, 10, 3]], ["C0", "circle", [-20, 5, 6]], ["A0", "arc", [25, -5, 8, 0.4, 2]],
    ["P0", "point", [30, 15]], ["E0", "ellipse", [-20, -15, 9, 4, 0.7]],
    ["S0", "bezier", [0, 10, 5, 18, 10, 2, 15, 12]],
  ]);
  const view = new View();
  Object.assign(view, { width: WIDTH, height: HEIGHT, x: 467, y: 348, scale: 10 });
  const swept = new Swept();
  swept.begin(WIDTH, HEIGHT);
  /** @type {number[][]} */
  const drawn = [];
  const ellipse = (x, y, rx, ry, turn, from, to) => {
    for (let i = 0; i <= 40; i++) {
      const a = from + ((to - from) * i) / 40;
      const [u, v] = [rx * Math.cos(a), ry * Math.sin(a)];
      drawn.push([x + u * Math.cos(turn) - v * Math.sin(turn), y + u * Math.sin(turn) + v * Math.cos(turn)]);
    }
  };
  const ctx = new Proxy({ ellipse }, {
    get: (target, name) => {
      if (name === "moveTo" || name === "lineTo") return (x, y) => drawn.push([x, y]);
      if (name === "bezierCurveTo") return (...p) => drawn.push(p.slice(4));
      if (name === "arc") return (x, y) => drawn.push([x, y]);
      return target[name] ?? (() => undefined);
    },
    set: () => true,
  });
  new Batches(store, () => true).draw(/** @type {any} */ (ctx), view, /** @type {any} */ ({}), swept);
  assert.ok(drawn.length > 130, `${drawn.length}`);
  const rects = cleared(swept);
  for (const [x, y] of drawn) assert.ok(covers(rects, x, y, 8), `${x}, ${y}`);
});
