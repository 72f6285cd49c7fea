/** What the panels, the command field and messages compute. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { amountText, shown } from "../../arael/sketch/page/amounts.js";
import { replaced } from "../../arael/sketch/page/completion.js";
import { marked, offers } from "../../arael/sketch/page/failure.js";
import { Past } from "../../arael/sketch/page/field.js";
import { base64, bytes } from "../../arael/sketch/page/files.js";
import { lit, pieces, span } from "../../arael/sketch/page/mention.js";
import { families } from "../../arael/sketch/page/palette.js";
import { readable, steps } from "../../arael/sketch/page/panels/history.js";
import { found } from "../../arael/sketch/page/panels/relations.js";
import { TOOLS } from "../../arael/sketch/page/tools/index.js";
import { summary } from "../../arael/sketch/page/top.js";
import { amount, argument } from "../../arael/sketch/page/tools/compose.js";
import { STEPS } from "../../arael/sketch/page/tour.js";
import { sketch } from "./panels_fakes.js";

const names = (list) => list.map((one) => one.name);

test("names in a sentence are found, ranges stand for all between", () => {
  const store = sketch();
  const sentence = "L0..L3 and A0 can move along x, L9 not; L0.p2 neither";
  const parts = pieces(sentence, (name) => store.has(name)).filter((one) => one.names.length);
  assert.deepEqual(parts, [
    { text: "L0..L3", names: ["L0", "L1", "L2", "L3"] },
    { text: "A0", names: ["A0"] },
    { text: "L0.p2", names: ["L0.p2"] },
  ]);
});

test("nothing of a sentence is lost between names", () => {
  const store = sketch();
  for (const text of ["", "L0", "d0: length L0 = 5 (width / 2)", "A0.center, (L1)", "L0..L9 and L0.nothing"]) {
    assert.equal(pieces(text, (name) => store.has(name)).map((one) => one.text).join(""), text);
  }
});

test("a range of different letters is its two ends", () => {
  assert.deepEqual(span("L0", "A3"), ["L0", "A3"]);
  assert.deepEqual(span("L3", "L1"), ["L3", "L1"]);
});

test("a constraint lights up what it relates, a group its entities", () => {
  const store = sketch();
  assert.deepEqual([...lit(store, ["C0"])], ["C0", "L0.p2", "L1.p1"]);
  assert.deepEqual([...lit(store, ["M0"])], ["M0", "L2", "L3"]);
});

test("the list of constraints is searched by name, kind and operands", () => {
  const store = sketch();
  assert.deepEqual(names(found(store, "", "all")), ["C0", "CL0H", "C4", "d0", "d1"]);
  assert.deepEqual(names(found(store, "L0 par", "all")), ["C4"]);
  assert.deepEqual(names(found(store, "horizontal", "all")), ["CL0H"]);
  assert.deepEqual(names(found(store, "", "dimensions")), ["d0", "d1"]);
  assert.deepEqual(names(found(store, "", "off")), ["C4"]);
  assert.deepEqual(names(found(store, "nothing", "all")), []);
});

test("problems are what the verdict marks, and broken expressions", () => {
  const store = sketch();
  store.receive({ type: "verdict", revision: 1, freedoms: 3, entities: {}, constraints: { CL0H: "redundant" }, full: true });
  assert.deepEqual(names(found(store, "", "problems")), ["CL0H", "d1"]);
});

test("constraints of the selection are those of its points, too", () => {
  const store = sketch();
  store.select(["L1"]);
  assert.deepEqual(names(found(store, "", "selected")), ["C0"]);
});

test("steps of the history go back and forth from the last one that is done", () => {
  const found = steps({ done: ["a", "b", "c"], undone: ["d", "e"] });
  assert.deepEqual(found.map((one) => one.command), ["undo 2", "undo 1", "", "redo 1", "redo 2"]);
  assert.deepEqual(found.map((one) => one.state), ["done", "done", "now", "undone", "undone"]);
});

test("a step is shown without the words by which a tool adds its constraints itself", () => {
  assert.equal(readable("add_line 0,0 20,0 noconnect notangent"), "add_line 0,0 20,0");
  assert.equal(readable("add_rect 0,0 4,3 hv"), "add_rect 0,0 4,3 hv");
});

test("redundant constraints are reported apart from impossible ones", () => {
  const store = sketch();
  const verdict = (constraints, freedoms = 2) => {
    store.receive({ type: "verdict", revision: 1, freedoms, entities: {}, constraints, full: true });
    return summary(store);
  };
  assert.deepEqual([verdict({}).state, verdict({}).text], ["free", "2 free"]);
  assert.deepEqual([verdict({}, 0).state, verdict({}, 0).text], ["defined", "Defined"]);
  assert.equal(verdict({ C4: "redundant" }).text, "1 redundant");
  assert.equal(verdict({ C4: "impossible", C0: "redundant" }).text, "1 impossible");
  assert.equal(verdict({ C4: "here" }).state, "free");
  store.revision += 1; // a command has run: what holds now is not known
  assert.deepEqual([summary(store).state, summary(store).text], ["unknown", "checking ..."]);
  store.receive({ type: "unjudged", revision: store.revision });
  assert.equal(summary(store).text, "not checked");
});

test("commands of a hint that take something out are offered", () => {
  const hint = "`delete CL2H` would give it something to hold; `force` lets it in as it is";
  assert.deepEqual(offers(hint), ["delete CL2H"]);
  assert.deepEqual(offers("set it first: `foo = 5`"), []);
});

test("what is typed stays one word of a command", () => {
  assert.equal(argument("width"), "width");
  assert.equal(argument("y 5; add_point 7,7 #"), '"y 5; add_point 7,7 #"');
  assert.equal(argument('a" ; clear'), '"a"" ; clear"');
  assert.deepEqual([amount("12.5"), amount("width / 2"), amount("=w*2")], ["12.5", '"width / 2"', '"w*2"']);
  assert.deepEqual([amount(">= 5 mm"), amount("5 to w + 1")], ['>= "5 mm"', '5 to "w + 1"']);
});

test("the place of an error is marked within the text", () => {
  assert.deepEqual(marked("length L0 foo", 10, 13), ["length L0 ", "foo", ""]);
  assert.deepEqual(marked("abc", 7, 9), ["abc", "", ""]);
});

test("the command field keeps what was being written", () => {
  const past = new Past(["one", "two"]);
  assert.equal(past.go(-1, "draft"), "two");
  assert.equal(past.go(-1, "two"), "one");
  assert.equal(past.go(-1, "one"), null);
  assert.equal(past.go(1, "one"), "two");
  assert.equal(past.go(1, "two"), "draft");
  assert.equal(past.go(1, "draft"), null);
  past.add("three");
  past.add("three");
  assert.deepEqual(past.lines, ["one", "two", "three"]);
});

test("a completed word takes the place of its beginning", () => {
  assert.deepEqual(replaced("length L0 wi", { from: 10, to: 12 }, "width"), { text: "length L0 width", caret: 15 });
  assert.deepEqual(replaced("le L0", { from: 0, to: 2 }, "length"), { text: "length L0", caret: 6 });
});

test("values of dimensions are shown as they are typed", () => {
  const amount = (text) => ({ text, number: Number(text) });
  const dimension = (fields) => amountText({ name: "d0", kind: "length", args: ["L0"], ...fields });
  assert.equal(dimension({ value: amount("width / 2") }), "width / 2");
  assert.equal(dimension({ low: amount("2"), high: amount("5") }), "2 to 5");
  assert.equal(dimension({ low: amount("2") }), ">= 2");
  assert.equal(dimension({ high: amount("5") }), "<= 5");
  assert.equal(shown(0.1 + 0.2), "0.3");
  assert.equal(shown(-0), "0");
  assert.equal(shown(12345678), "12345700");
});

test("files survive the way as base64", () => {
  const data = Uint8Array.from({ length: 100_000 }, (_, i) => (i * 7) % 256);
  assert.deepEqual(bytes(base64(data)), data);
});

test("every tool stands in exactly one family of the palette", () => {
  const all = families(TOOLS).flatMap((family) => family.tools);
  assert.deepEqual([...all].sort(), TOOLS.map((tool) => tool.id).sort());
});

test("the tour has six steps", () => assert.equal(STEPS.length, 6));
