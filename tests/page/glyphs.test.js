/** Layout of badges and texts: none on top of another, hidden where they are too small. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { layoutDimension } from "../../arael/sketch/page/draw/dimensions.js";
import { HALF, layoutGlyphs } from "../../arael/sketch/page/draw/glyphs.js";
import { Places } from "../../arael/sketch/page/draw/places.js";
import { SYMBOLS } from "../../arael/sketch/page/draw/symbols.js";
import { dimensionText } from "../../arael/sketch/page/draw/texts.js";
import { scene } from "./sketches.js";

const rectangle = () =>
  scene(
    [["L0", "line", [0, 0, 10, 0]], ["L1", "line", [10, 0, 10, 5]], ["L2", "line", [10, 5, 0, 5]], ["L3", "line", [0, 5, 0, 0]]],
    [
      ["C0", "coincident", ["L0.p2", "L1.p1"]], ["CL0H", "horizontal", ["L0"]], ["C1", "parallel", ["L0", "L2"]],
      ["C2", "perpendicular", ["L0", "L1"]], ["C3", "equal", ["L0", "L2"]], ["C4", "equal", ["L1", "L3"]], ["C5", "lock", ["L0.p1"]],
    ],
  );

test("no badge overlaps another", () => {
  const { store, view } = rectangle();
  const glyphs = layoutGlyphs({ store, view }, new Places(), new Set()).filter((glyph) => !glyph.ring);
  assert.equal(glyphs.length, 9);
  for (const a of glyphs) {
    for (const b of glyphs) {
      const apart = a === b || Math.abs(a.x - b.x) >= 2 * HALF || Math.abs(a.y - b.y) >= 2 * HALF;
      assert.ok(apart, `${a.name} and ${b.name}`);
    }
  }
});

test("badges of what is small on the screen are hidden, unless they are wanted", () => {
  const { store, view } = rectangle();
  view.scale = 2;
  const shown = (always) => layoutGlyphs({ store, view }, new Places(), new Set(always)).map((glyph) => glyph.name);
  assert.ok(!shown([]).includes("CL0H"));
  assert.ok(shown(["CL0H"]).includes("CL0H"));
});

test("a badge is picked where it is laid out", () => {
  const { store, view } = rectangle();
  const places = new Places();
  const [glyph] = layoutGlyphs({ store, view }, places, new Set()).filter((one) => one.name === "CL0H");
  assert.deepEqual(places.at(glyph.x + 3, glyph.y - 3), ["CL0H"]);
  assert.deepEqual(places.at(glyph.x + 30, glyph.y + 30), []);
});

test("a badge that was dragged keeps its distance from its anchor", () => {
  const { store, view } = rectangle();
  const at = (nudged) => layoutGlyphs({ store, view, nudged }, new Places(), new Set()).find((one) => one.name === "CL0H");
  const [a, b] = [at(new Map()), at(new Map([["CL0H", [40, 25]]]))];
  assert.deepEqual([b.x - a.x, b.y - a.y], [40, 25]);
});

test("every kind of constraint has a symbol", () => {
  assert.equal(Object.keys(SYMBOLS).length, 18);
});

const pen = ({ store, view }) => ({ store, view, middle: [5, 2.5], places: new Places(), width: (text) => 7 * text.length });

test("every kind of dimension is drawn", () => {
  const sketch = scene([
    ["L0", "line", [0, 0, 10, 0]], ["L1", "line", [0, 0, 5, 5]], ["A0", "circle", [3, 3, 2]],
    ["A1", "arc", [0, 0, 2, 0, 0, 2, 2]], ["EA0", "ellipse", [0, 0, 4, 2, 0.2]],
  ]);
  const kinds = {
    length: ["L0"], distance: ["L0.p1", "L1.p2"], hdistance: ["L0.p1", "L1.p2"], vdistance: ["L0.p1", "L1.p2"],
    radius: ["A0"], diameter: ["A0"], radius_b: ["EA0"], sweep: ["A1"], arc_length: ["A1"], angle: ["L0", "L1"],
    xangle: ["L1"], total_length: ["L0", "L1"], area: ["A0"],
  };
  for (const [kind, args] of Object.entries(kinds)) {
    const d = { name: "d0", kind, args, value: { text: "5", number: 5 } };
    const drawn = layoutDimension(pen(sketch), d, dimensionText(d, "mm"));
    assert.ok(drawn, kind);
    assert.ok([drawn.text.x, drawn.text.y].every(Number.isFinite), kind);
  }
  assert.equal(layoutDimension(pen(sketch), { name: "d0", kind: "length", args: ["L9"] }, "5"), null);
});

test("a text that is dropped stays where it was dropped", () => {
  const sketch = rectangle();
  for (const [kind, args] of [["length", ["L0"]], ["vdistance", ["L0.p1", "L1.p2"]]]) {
    const d = { name: "d0", kind, args, value: { text: "10", number: 10 } };
    const wanted = sketch.view.toScreen([7, 9]);
    const moved = { ...d, ...layoutDimension(pen(sketch), d, "10").placeAt(wanted) };
    const { text } = layoutDimension(pen(sketch), moved, "10");
    const slack = kind === "vdistance" ? 1e9 : 1e-6;
    assert.ok(Math.abs(text.x - wanted[0]) < 1e-6 && Math.abs(text.y - wanted[1]) < slack, `${kind}: ${text.x},${text.y} ${wanted}`);
  }
});

test("texts of dimensions", () => {
  const d = (more) => ({ name: "d0", kind: "length", args: ["L0"], ...more });
  const amount = (number, text = String(number)) => ({ number, text });
  assert.equal(dimensionText(d({ value: amount(12.5) }), "mm"), "12.5");
  assert.equal(dimensionText(d({ value: amount(12, "w/2") }), "mm"), "ƒ 12");
  assert.equal(dimensionText(d({ value: amount(0.5, "0.5 in") }), "in"), "0.5");
  assert.equal(dimensionText(d({ low: amount(2) }), "mm"), "≥ 2");
  assert.equal(dimensionText(d({ low: amount(2), high: amount(5) }), "mm"), "2 … 5");
  assert.equal(dimensionText(d({ value: amount(3), derived: true }), "mm", 4), "(4)");
  assert.equal(dimensionText({ name: "d0", kind: "angle", args: [], value: amount(-30) }, "mm"), "−30°");
  assert.equal(dimensionText({ name: "d0", kind: "diameter", args: [], value: amount(8) }, "mm"), "⌀8");
  assert.equal(dimensionText(d({ kind: "diameter", value: amount(8, "2*r") }), "mm"), "⌀ ƒ 8");
  assert.equal(dimensionText(d({ kind: "arc_length", value: amount(8, "2*r") }), "mm"), "◠ ƒ 8");
  assert.equal(dimensionText(d({ kind: "radius", low: amount(2) }), "mm"), "R ≥ 2");
});
