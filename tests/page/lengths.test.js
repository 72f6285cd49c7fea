/** Lengths in another unit than that of the part: what is shown and what typed numbers mean. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { dimensionText } from "../../arael/sketch/page/draw/texts.js";
import { Lengths } from "../../arael/sketch/page/lengths.js";
import { Typed } from "../../arael/sketch/page/tools/typed.js";
import { View } from "../../arael/sketch/page/view.js";

const inches = () => {
  const found = new Lengths({ unit: "mm" });
  found.set("in");
  return found;
};
const dimension = (kind, text, number) => ({ name: "d0", kind, args: [], value: { text, number } });

test("numbers of the part are converted, with their unit", () => {
  const lengths = inches();
  assert.equal(dimensionText(dimension("length", "50.8", 50.8), lengths), "2 in");
  assert.equal(dimensionText(dimension("radius", "w / 2", 25.4), lengths), "R ƒ 1 in");
  assert.equal(dimensionText(dimension("area", "1290.32", 1290.32), lengths), "A 2 in²");
  assert.equal(dimensionText(dimension("angle", "30", 30), lengths), "30°");
  assert.equal(lengths.amount(dimension("length", "50.8", 50.8)), "2 in");
  assert.equal(lengths.amount(dimension("length", "w / 2", 50.8)), "w / 2");
  assert.equal(lengths.amount(dimension("length", "5 cm", 50)), "5 cm");
  assert.equal(lengths.amount(dimension("xangle", "30", 30)), "30");
  const range = { ...dimension("length", "", 0), value: null, low: { text: "25.4", number: 25.4 }, high: { text: "w", number: 99 } };
  assert.equal(lengths.amount(range), "1 in to w");
});

test("typed numbers are in the unit that is shown", () => {
  const lengths = inches();
  const typed = (text) => lengths.typed(text, "length");
  assert.equal(typed("2"), "2 in");
  assert.equal(typed("= .5"), "=.5 in");
  assert.equal(typed(">=2"), ">= 2 in");
  assert.equal(typed("1 to 2.5"), "1 in to 2.5 in");
  assert.equal(typed("(1 + 2) / 4"), "((1 + 2) / 4) * 1 in");
  for (const text of ["w / 2", "5 mm", "L0.length", "1e", ""]) assert.equal(typed(text), text);
  assert.equal(lengths.typed("30", "angle"), "30");
  assert.equal(Number(lengths.typed("2", "area")), 2 * 25.4 ** 2);
});

test("in the unit of the part nothing is converted, whatever it becomes", () => {
  const store = { unit: "mm" };
  const lengths = new Lengths(store);
  lengths.set("in");
  lengths.set("mm");
  store.unit = "cm";
  assert.equal(lengths.other, false);
  assert.equal(lengths.name, "cm");
  assert.equal(lengths.typed("2", "length"), "2");
  assert.equal(lengths.amount(dimension("length", "2.50", 2.5)), "2.50");
});

test("fields while drawing: the pointer's length and the typed one are of one unit", () => {
  const typed = new Typed(inches());
  const fields = [
    { id: "radius", title: "radius", text: "", value: 1, quantity: "length" },
    { id: "sides", title: "sides", text: "", value: 6, quantity: "count" },
  ];
  typed.key({ key: "2" }, fields);
  assert.equal(typed.number("radius", 0), 50.8);
  assert.equal(typed.word("radius"), '"2 in"');
  typed.key({ key: "Tab" }, fields);
  typed.key({ key: "8" }, fields);
  assert.equal(typed.number("sides", 0), 8);
  assert.equal(typed.text("sides"), "8");
});

test("grid lines are at round numbers of what is shown", () => {
  const view = new View();
  view.scale = 10;
  assert.equal(view.gridStep(), 2);
  view.factor = 1 / 25.4;
  assert.ok(Math.abs(view.gridStep() / 25.4 - 0.05) < 1e-12);
});
