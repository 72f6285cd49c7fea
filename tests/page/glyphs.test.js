/** Layout of badges and texts: none on top of another, hidden where they are too small. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { Annotations } from "../../arael/sketch/page/draw/annotations.js";
import { drawDimensions } from "../../arael/sketch/page/draw/dimension_marks.js";
import { Batches } from "../../arael/sketch/page/draw/batches.js";
import { layoutDimension, measured } from "../../arael/sketch/page/draw/dimensions.js";
import { HALF, layoutGlyphs } from "../../arael/sketch/page/draw/glyphs.js";
import { Places, SamePlaces } from "../../arael/sketch/page/draw/places.js";
import { SYMBOLS } from "../../arael/sketch/page/draw/symbols.js";
import { dimensionText } from "../../arael/sketch/page/draw/texts.js";
import { Lengths } from "../../arael/sketch/page/lengths.js";
import { scene } from "./sketches.js";

const MM = new Lengths({ unit: "mm" });

const rectangle = () =>
  scene(
    [["L0", "line", [0, 0, 10, 0]], ["L1", "line", [10, 0, 10, 5]], ["L2", "line", [10, 5, 0, 5]], ["L3", "line", [0, 5, 0, 0]]],
    [
      ["C0", "coincident", ["L0.p2", "L1.p1"]], ["CL0H", "horizontal", ["L0"]], ["C1", "parallel", ["L0", "L2"]],
      ["C2", "perpendicular", ["L0", "L1"]], ["C3", "equal", ["L0", "L2"]], ["C4", "equal", ["L1", "L3"]], ["C5", "lock", ["L0.p1"]],
    ],
  );

test("angles are measured while they are dragged, as at rest", () => {
  const { store } = scene([["L0", "line", [0, 0, 10, 0]], ["L1", "line", [0, 0, 3, 3]], ["L2", "line", [0, 0, -3, -3]]]);
  const value = (kind, args, mode) => Math.round(measured(store, { name: "d0", kind, args, mode }) * 1e9) / 1e9;
  assert.equal(value("angle", ["L0", "L1"]), 45);
  assert.equal(value("angle", ["L1", "L0"]), -45);
  assert.equal(value("angle", ["L0", "L2"]), -135);
  assert.equal(value("angle", ["L0", "L1"], "supplement"), -135);
  assert.equal(value("angle", ["L0", "L2"], "supplement"), 45);
  assert.equal(value("xangle", ["L2"]), -135);
});

test("a spline that is selected, or a pole of it, shows its control polygon", () => {
  const poles = [0, 0, 1, 2, 3, 2, 4, 0, 6, 1];
  const { store, view } = scene([["S0", "bspline", poles], ["S1", "bspline", poles.map((x) => x + 20)], ["L0", "line", [0, 0, 9, 9]]]);
  const drawn = (/** @type {string[]} */ ...names) => {
    store.select(names);
    const pen = [];
    const ctx = new Proxy({}, {
      get: (_, key) => (...given) => void (key === "moveTo" || key === "lineTo" ? pen.push(given) : 0),
      set: () => true,
    });
    new Batches(store, () => true)._polygons(ctx, view, { guide: "grey" });
    return pen;
  };
  const expected = [[0, 0], [1, 2], [3, 2], [4, 0], [6, 1]].map((pole) => view.toScreen(pole));
  assert.deepEqual(drawn("S0"), expected);
  assert.deepEqual(drawn("L0", "S0.pole3"), expected);
  assert.deepEqual(drawn("S0.p1"), expected);
  assert.deepEqual(drawn("L0"), []);
  assert.equal(drawn("S0", "S1").length, 10);
});

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

test("badges are those of what is selected, hovered or in conflict; all of them when asked for", () => {
  const { annotations, store, ctx } = annotated();
  const names = () => (annotations.layout(ctx), [...new Set(annotations.glyphs.map((one) => one.name))].sort());
  assert.deepEqual(names(), [...store.constraints.keys()].sort());
  annotations.shown.glyphs = false;
  assert.deepEqual(names(), []);
  store.select(["L1"]);
  assert.deepEqual(names(), ["C0", "C2", "C4"]);
  store.select(["L0.p1"]);
  assert.deepEqual(names(), ["C5"]);
  store.select([]);
  store.verdict.constraints = { C3: "redundant" };
  assert.deepEqual(names(), ["C3"]);
  store.hover(["L3"]);
  assert.deepEqual(annotations.hoveredGlyphs().map((one) => one.name), ["C4", "C4"]);
  assert.deepEqual(annotations.glyphs.map((one) => one.name), ["C3", "C3"], "hovering lays out nothing anew");
});

test("a group has one badge, which stands for it", () => {
  const { store, view } = rectangle();
  store.groups.set("M0", { name: "M0", kind: "pattern", owned: ["C0", "C1", "C2", "C3"] });
  const names = (always) => layoutGlyphs({ store, view }, new Places(), new Set(always)).map((one) => one.name);
  assert.equal(names([]).filter((one) => one === "M0").length, 1);
  assert.ok(!names([]).some((one) => ["C0", "C1", "C2", "C3"].includes(one)));
  assert.ok(names(["C3"]).includes("C3"), "one of them that is wanted is shown by itself");
});

test("a badge without a free place is left out, and one that has a place keeps it", () => {
  const { store, view } = rectangle();
  const places = new Places();
  const [x, y] = view.toScreen([5, 0]);
  places.take(x, y, 400, 400);
  assert.deepEqual(layoutGlyphs({ store, view }, places, new Set(["CL0H"]), [store.constraints.get("CL0H")]), []);
  const choices = new Map();
  const at = (constraints) => layoutGlyphs({ store, view }, new Places(), new Set(), constraints, choices).find((one) => one.of === "C3");
  const all = at(store.constraints.values());
  const alone = at([store.constraints.get("C3")]);
  assert.deepEqual([alone.x, alone.y], [all.x, all.y]);
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

/** A context that measures texts and counts what is drawn. */
function context() {
  const counts = {};
  const ctx = new Proxy({ measureText: (text) => ({ width: 7 * text.length }) }, {
    get: (own, name) => own[name] ?? ((..._) => (counts[name] = (counts[name] ?? 0) + 1)),
    set: () => true,
  });
  return { ctx, counts };
}

/** Annotations of the rectangle with a dimension, laid out. */
function annotated() {
  const { store, view } = rectangle();
  store.dimensions.set("d0", { name: "d0", kind: "length", args: ["L0"], value: { text: "10", number: 10 } });
  const annotations = new Annotations(store, view);
  annotations.shown.glyphs = true;
  const { ctx } = context();
  annotations.layout(ctx);
  return { annotations, store, view, ctx };
}

test("the badge of an arc keeps off the leader of its radius", () => {
  const { store, view } = scene(
    [["A0", "arc", [0, 0, 5, 0, 10, 0, 5]], ["A1", "arc", [20, 0, 25, 0, 30, 0, 5]]],
    [["C0", "equal", ["A0", "A1"]]],
  );
  store.dimensions.set("d0", { name: "d0", kind: "radius", args: ["A0"], value: { text: "5", number: 5 } });
  const annotations = new Annotations(store, view);
  annotations.shown.glyphs = true;
  annotations.layout(context().ctx);
  const [x1, y1, x2, y2] = annotations.dimensions[0].lines;
  assert.ok(annotations.glyphs.length === 2);
  for (const { x, y } of annotations.glyphs) {
    const t = Math.min(Math.max(((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / Math.hypot(x2 - x1, y2 - y1) ** 2, 0), 1);
    const apart = Math.max(Math.abs(x - x1 - t * (x2 - x1)), Math.abs(y - y1 - t * (y2 - y1)));
    assert.ok(apart >= HALF, `${x}, ${y} is ${apart} from the leader`);
  }
});

test("texts and badges keep off points, and off the extension lines of dimensions", () => {
  // the leader of the radius leads to the corner, where a point is and an extension line begins
  const { store, view } = scene(
    [["L0", "line", [0, 0, 40, 0]], ["A0", "arc", [35, 25, 40, 25, 35, 30, 5]], ["P0", "point", [40, 30]], ["L1", "line", [0, 30, 0, 0]]],
    [["CL0H", "vertical", ["L1"]]],
  );
  for (const [name, kind, args] of [["d0", "radius", ["A0"]], ["d1", "vdistance", ["L0.p2", "P0"]], ["d2", "hdistance", ["L1.p1", "P0"]]]) {
    store.dimensions.set(name, { name, kind, args, value: { text: "5", number: 5 } });
  }
  view.scale = 8;
  view.centre([20, 15]);
  const annotations = new Annotations(store, view);
  annotations.shown.glyphs = true;
  annotations.layout(context().ctx);
  const taken = [
    ...annotations.dimensions.map(({ name, half, text }) => ({ name, x: text.x, y: text.y, w: text.angle ? 6 : half, h: text.angle ? half : 6 })),
    ...annotations.glyphs.filter((one) => !one.ring).map(({ name, x, y }) => ({ name, x, y, w: HALF, h: HALF })),
  ];
  assert.equal(taken.length, 4);
  const [px, py] = view.toScreen([40, 30]);
  for (const { name, x, y, w, h } of taken) {
    assert.ok(Math.abs(px - x) >= w + 3 || Math.abs(py - y) >= h + 3, `${name} is on the point`);
    for (const { name: other, thin } of annotations.dimensions) {
      for (let k = 0; k < thin.length; k += 4) {
        const [x1, y1, x2, y2] = thin.slice(k, k + 4);
        const through = [0, 0.25, 0.5, 0.75, 1].some((t) => Math.abs(x1 + t * (x2 - x1) - x) < w && Math.abs(y1 + t * (y2 - y1) - y) < h);
        assert.ok(!through || name === other, `${name} is on an extension line of ${other}`);
      }
    }
  }
});

test("a dimension line does not pass through a text that was there before", () => {
  const { store, view } = rectangle();
  const add = (name, args, more) => store.dimensions.set(name, { name, kind: "hdistance", args, value: { text: "10", number: 10 }, ...more });
  // the first text stands where the line of the second would be
  add("d0", ["L2.p2", "L2.p1"], { offset: 3.4, along: 0.4 });
  add("d1", ["L2.p2", "L2.p1"], {});
  const annotations = new Annotations(store, view);
  annotations.layout(context().ctx);
  const [first, second] = annotations.dimensions;
  const [x1, y1, x2] = second.lines;
  const { x, y } = first.text;
  assert.ok(x > Math.min(x1, x2) && x < Math.max(x1, x2));
  assert.ok(Math.abs(y1 - y) >= 8, `a line at ${y1}, a text at ${y}`);
});

test("in a drag texts and badges move with what they belong to, on the side where they are", () => {
  const { annotations, store, view, ctx } = annotated();
  const before = { dimensions: annotations.dimensions, glyphs: annotations.glyphs };
  annotations.split(new Set(["L0", "L1", "L2", "L3"]));
  for (let i = 0; i < store.values.length; i += 2) store.values[i] += 3;
  const after = annotations.follow(ctx);
  const x = (shown) => [shown.dimensions[0].text.x, ...shown.glyphs.filter((one) => !one.ring).map((one) => one.x)];
  assert.equal(after.glyphs.length, before.glyphs.filter((one) => !one.ring).length);
  assert.deepEqual(x(after).map((one) => one.toFixed(6)), x(before).map((one) => (one + 3 * view.scale).toFixed(6)));
});

test("dimensions in a drag are where a new layout would put them", () => {
  const { store, view } = scene([
    ["L0", "line", [0, 0, 30, 0]], ["L1", "line", [30, 0, 30, 20]], ["A0", "arc", [50, 10, 55, 10, 50, 15, 5]],
    ["A1", "circle", [70, 10, 6]], ["P0", "point", [10, 30]], ["B0", "bezier", [0, 40, 10, 50, 20, 30, 30, 40]],
  ]);
  const kinds = [
    ["length", ["L0"]], ["length", ["L1"]], ["radius", ["A0"]], ["diameter", ["A1"]], ["sweep", ["A0"]], ["angle", ["L0", "L1"]],
    ["hdistance", ["L0.p1", "P0"]], ["distance", ["A0.center", "A1.center"]], ["xangle", ["L1"]], ["total_length", ["B0"]], ["area", ["L0", "L1"]],
  ];
  for (const [i, [kind, args]] of kinds.entries()) {
    store.dimensions.set(`d${i}`, { name: `d${i}`, kind, args, value: { text: "5", number: 5 }, derived: i % 2 === 0 });
  }
  view.scale = 7;
  const annotations = new Annotations(store, view);
  const { ctx } = context();
  annotations.layout(ctx);
  assert.equal(annotations.dimensions.length, kinds.length);
  const all = new Set(store.entities.keys());
  annotations.split(all);
  const start = store.values.slice();
  const [line, arc] = [store.entities.get("L0"), store.entities.get("A0")];
  const round = (drawn) => JSON.parse(JSON.stringify(drawn, (_, one) => (typeof one === "number" ? Math.round(20 * one) : one)));
  const check = (/** @type {string} */ what) => {
    const kept = round(annotations.follow(ctx).dimensions);
    annotations._moving.dimensions.forEach((one) => (one._drawn = null));
    assert.deepEqual(kept, round(annotations.follow(ctx).dimensions), what);
  };
  check("where it was");
  const moves = { // x and y of everything, then of one entity, then what has no place
    "to the right": () => pairs(0, 1.25), "up": () => pairs(1, 0.5), "one end": () => (store.values[line.at + 2] += 1.5),
    "one line": () => [0, 2].forEach((k) => (store.values[line.at + k] += 0.75)), "a radius": () => (store.values[arc.at + 6] += 0.5),
    "a circle's": () => (store.values[store.entities.get("A1").at + 2] += 0.25), "back": () => store.values.set(start),
  };
  const pairs = (from, by) => {
    for (const { at, kind, size } of store.entities.values()) {
      for (let k = from; k < (kind === "arc" ? 6 : kind === "circle" ? 2 : size); k += 2) store.values[at + k] += by;
    }
  };
  for (const [what, move] of Object.entries(moves)) {
    annotations.follow(ctx);
    move();
    check(what);
    pairs(1, 0.25);
    annotations.follow(ctx);
    pairs(0, 0.125);
    annotations.follow(ctx);
    pairs(1, -0.125);
    check(`${what}, then up, to the right and down`);
  }
});

test("what a drag does not move is laid out once", () => {
  const { annotations, ctx } = annotated();
  annotations.split(new Set(["L1"]));
  assert.deepEqual(annotations.still.dimensions.map((one) => one.name), ["d0"]);
  const moving = annotations.follow(ctx);
  assert.deepEqual(new Set(moving.glyphs.map((one) => one.name)), new Set(["C2", "C4"]));
  assert.equal(moving.dimensions.length, 0);
  const still = new Set(annotations.still.glyphs.map((one) => one.name));
  assert.ok(still.has("CL0H") && !still.has("C2"));
});

test("the same choices again, and the first place where none was free", () => {
  const choices = new Map();
  const places = new Places();
  const spots = [[0, 0], [50, 0], [100, 0]];
  for (const key of ["a", "b", "c", "d"]) {
    places.choosing(key);
    const [x, y] = places.firstFree(spots, 9, 9);
    places.take(x, y, 9, 9);
    choices.set(key, places.refused);
  }
  assert.deepEqual([...choices.values()], [0, 1, 2, -1]);
  const same = new SamePlaces(choices);
  const found = ["d", "c", "b", "a"].map((key) => (same.choosing(key), same.firstFree(spots, 9, 9)[0]));
  assert.deepEqual(found, [0, 100, 50, 0]);
});

test("dimensions of one colour are drawn in one stroke for each kind of line", () => {
  const { store, view } = rectangle();
  const pen = { store, view, places: new Places(), middle: [5, 2], width: () => 20 };
  const all = ["L0", "L1", "L2"].map((name) => layoutDimension(pen, { name, kind: "length", args: [name] }, "1"));
  const { ctx, counts } = context();
  drawDimensions(ctx, all, "red", "white");
  assert.deepEqual([counts.stroke, counts.fill, counts.fillText], [2, 1, 3]);
});

test("ends that coincide have one mark", () => {
  const { store, view } = rectangle();
  const { ctx, counts } = context();
  new Batches(store, () => true).draw(ctx, view, {});
  assert.equal(counts.arc, 8); // four rings, of two discs each
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
    const drawn = layoutDimension(pen(sketch), d, dimensionText(d, MM));
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
  assert.equal(dimensionText(d({ value: amount(12.5) }), MM), "12.5");
  assert.equal(dimensionText(d({ value: amount(12, "w/2") }), MM), "ƒ 12");
  assert.equal(dimensionText(d({ value: amount(0.5, "0.5 in") }), new Lengths({ unit: "in" })), "0.5");
  assert.equal(dimensionText(d({ low: amount(2) }), MM), "≥ 2");
  assert.equal(dimensionText(d({ low: amount(2), high: amount(5) }), MM), "2 … 5");
  assert.equal(dimensionText(d({ value: amount(3), derived: true }), MM, 4), "(4)");
  assert.equal(dimensionText({ name: "d0", kind: "angle", args: [], value: amount(-30) }, MM), "−30°");
  assert.equal(dimensionText({ name: "d0", kind: "diameter", args: [], value: amount(8) }, MM), "⌀8");
  assert.equal(dimensionText(d({ kind: "diameter", value: amount(8, "2*r") }), MM), "⌀ ƒ 8");
  assert.equal(dimensionText(d({ kind: "arc_length", value: amount(8, "2*r") }), MM), "◠ ƒ 8");
  assert.equal(dimensionText(d({ kind: "radius", low: amount(2) }), MM), "R ≥ 2");
});
