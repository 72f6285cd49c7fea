/** Texts: picked by their lettering, drawn in the look of their state. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { Annotations } from "../../arael/sketch/page/draw/annotations.js";
import { Batches } from "../../arael/sketch/page/draw/batches.js";
import { traceLettering } from "../../arael/sketch/page/draw/lettering.js";
import { boundsOfAll } from "../../arael/sketch/page/geometry/boxes.js";
import { widthOf } from "../../arael/sketch/page/geometry/lettering.js";
import { quoted } from "../../arael/sketch/page/tools/compose.js";
import { scene, stored, viewed } from "./sketches.js";

const WIDTH = 4 * widthOf("Hallo");
const text = (more = {}) => ["L0", "line", [0, 0, WIDTH, 0], { text: "Hallo", ...more }];
const names = ({ picker, view }, x, y) => picker.all(view.toScreen([x, y])).map((pick) => pick.name);

test("a text is picked by its lettering, other curves within it before it", () => {
  const sketch = scene([text(), ["A0", "circle", [5, 3, 1]]]);
  assert.deepEqual(names(sketch, 3, 2), ["L0"]);
  assert.deepEqual(names(sketch, 5, 4), ["A0", "L0"]);
  assert.deepEqual(names(sketch, 3, -4), []);
  assert.deepEqual(names(sketch, WIDTH + 2, 2), []);
});

test("a plain line is not picked beside itself", () => {
  assert.deepEqual(names(scene([["L0", "line", [0, 0, WIDTH, 0]]]), 3, 2), []);
});

test("a turned text is picked where it is", () => {
  const sketch = scene([["L0", "line", [0, 0, 0, WIDTH], { text: "Hallo" }]]);
  assert.deepEqual(names(sketch, -2, 3), ["L0"]);
  assert.deepEqual(names(sketch, 3, 3), []);
});

test("a text is in a box with its lettering", () => {
  const { picker, view } = scene([text()]);
  const box = (a, b, touched) => picker.inBox(view.toScreen(a), view.toScreen(b), touched);
  assert.deepEqual(box([-1, -1], [WIDTH + 1, 1], false), []);
  assert.deepEqual(box([-1, -2], [WIDTH + 1, 6], false), ["L0"]);
  assert.deepEqual(box([5, 6], [3, 3], true), ["L0"]);
});

test("the bounds of the drawing hold the lettering", () => {
  const { ymin, ymax } = boundsOfAll(stored([text()]));
  assert.ok(ymin < -1 && ymax > 4);
});

test("a changed text is picked by its new box", () => {
  const sketch = scene([text()]);
  assert.deepEqual(names(sketch, 3, 8), []);
  const { store, picker } = sketch;
  const put = { entities: [{ name: "L0", kind: "line", at: 0, size: 4, text: "H" }] };
  store.receive({ type: "change", from: 7, revision: 8, put, removed: {}, offsets: [], numbers: [] });
  picker.changed({ put, removed: {}, all: false });
  assert.deepEqual(names(sketch, 3, 8), ["L0"]);
});

const looks = (more, shown) =>
  new Batches(stored([text(more)]), () => true, shown).batches.map((b) => [b.construction, b.lines.length, b.texts.length]);

test("the base line is thin, of a quiet text it is left out", () => {
  assert.deepEqual(looks({}), [[true, 1, 0], [false, 0, 1]]);
  assert.deepEqual(looks({ quiet: true }), [[false, 0, 1]]);
  assert.deepEqual(looks({}, { construction: false }), [[false, 0, 1]]);
  assert.deepEqual(looks({ construction: true }), [[true, 1, 1]]);
});

function traced(view) {
  const steps = [];
  const log = (name) => (...numbers) => steps.push([name, ...numbers]);
  const ctx = { moveTo: log("moveTo"), lineTo: log("lineTo"), arc: log("arc") };
  traceLettering(ctx, view, { text: "Hallo", at: 0 }, new Float64Array([0, 0, WIDTH, 0]));
  return steps;
}

test("a text that is too small to be read is a line, one outside is not drawn", () => {
  const view = viewed();
  assert.ok(traced(view).length > 20);
  view.scale = 0.1;
  assert.deepEqual(traced(view).map(([name]) => name), ["moveTo", "lineTo"]);
  view.scale = 10;
  view.pan(5000, 0);
  assert.deepEqual(traced(view), []);
});

test("dimensions and badges keep off the lettering, at any zoom", () => {
  const view = viewed();
  const ctx = { font: "", measureText: () => ({ width: 20 }) };
  for (const scale of [10, 1e6]) {
    view.scale = scale;
    const annotations = new Annotations(stored([text()]), view);
    annotations.layout(ctx);
    assert.equal(annotations.places.isFree(...view.toScreen([3, 2]), 4, 4), scale !== 10);
  }
});

test("a text is one word of a command", () => {
  assert.equal(quoted('1/4" pipe'), '"1/4"" pipe"');
});
