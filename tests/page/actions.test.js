/** The table of actions: keys, and which selections each constraint and dimension takes. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { GROUPS, allActions, tooltip } from "../../arael/sketch/page/actions.js";
import { CONSTRAINTS } from "../../arael/sketch/page/actions/constraints.js";
import { DIMENSIONS } from "../../arael/sketch/page/actions/dimensions.js";
import { TOOL_KEYS } from "../../arael/sketch/page/actions/tools.js";
import { WORDS } from "../../arael/sketch/page/actions/words.js";
import { isFound } from "../../arael/sketch/page/help.js";
import { hasIcon } from "../../arael/sketch/page/icons.js";
import { picked } from "../../arael/sketch/page/picked.js";
import { TOOLS } from "../../arael/sketch/page/tools/index.js";
import { sketch } from "./panels_fakes.js";

const all = allActions(TOOLS);

test("actions are found by the words of other programs", () => {
  const found = (/** @type {string} */ word) => all.filter((one) => isFound(one, word)).map((one) => one.id);
  assert.deepEqual(found("bolt circle"), ["tool_pattern_circular"]);
  assert.deepEqual(found("driven").sort(), ["set_derived", "set_driven"]);
  assert.ok(found("reference").includes("set_derived"));
  assert.deepEqual(found("array"), ["tool_pattern_circular", "tool_pattern_rect"]);
  assert.ok(found("origin").includes("lock") && found("snap").includes("grid"));
  for (const id of Object.keys(WORDS)) assert.ok(all.some((one) => one.id === id), `no action ${id}`);
});

test("no key belongs to two actions", () => {
  const seen = new Map();
  for (const one of all) {
    for (const key of [one.key, ...(one.also ?? [])].filter(Boolean)) {
      assert.equal(seen.get(key), undefined, `${key}: ${seen.get(key)} and ${one.id}`);
      seen.set(key, one.id);
    }
  }
});

test("B alone is no action: held, it leaves automatic constraints off", () => {
  assert.ok(all.every((one) => ![one.key, ...(one.also ?? [])].includes("B")));
});

test("every tool, constraint and dimension has a key and an icon", () => {
  for (const one of all.filter(({ group }) => ["tool", "constrain", "dimension"].includes(group))) {
    assert.ok(one.key, `${one.id} has no key`);
    assert.ok(hasIcon(one.id), `${one.id} has no icon`);
  }
});

test("keys of tools are those of tools that exist", () => {
  const ids = TOOLS.map((tool) => tool.id);
  for (const id of Object.keys(TOOL_KEYS)) assert.ok(ids.includes(id), `no tool ${id}`);
});

test("the keys of the design are kept", () => {
  const byKey = new Map(all.map((one) => [one.key, one.id]));
  const design = {
    L: "tool_line",
    O: "tool_circle",
    A: "tool_arc",
    P: "tool_point",
    D: "tool_dimension",
    S: "tool_select",
    H: "horizontal",
    V: "vertical",
    C: "coincident",
    T: "tangent",
    M: "midpoint",
    K: "lock",
    X: "construction",
    "/": "command",
  };
  for (const [key, id] of Object.entries(design)) assert.equal(byKey.get(key), id, key);
});

test("every action stands in a group of the help and has a title", () => {
  for (const one of all) {
    assert.ok(one.group in GROUPS, one.id);
    assert.ok(one.title, one.id);
  }
  assert.equal(new Set(all.map(({ id }) => id)).size, all.length);
});

test("a tooltip has the key and what the action needs", () => {
  const one = all.find(({ id }) => id === "parallel");
  assert.equal(tooltip(one), "Parallel (Q): two or more lines, or a line and an ellipse");
});

const COMMANDS = {
  horizontal: { "L0 L1": "horizontal L0 L1", "P0 L0.p1": "horizontal P0 L0.p1", "L0 P0": "" },
  vertical: { L1: "vertical L1", A0: "" },
  coincident: {
    "L0.p2 L1.p1": "coincident L0.p2 L1.p1",
    "P0 L0.p1 L1.p2": "coincident P0 L0.p1; coincident P0 L1.p2",
    P0: "",
  },
  point_on: { "P0 A0": "point_on P0 A0", "A0 P0": "point_on P0 A0", "P0 L0.p1": "", "P0 L0 L1": "" },
  midpoint: { "P0 L0": "midpoint P0 L0", "A1 P0": "midpoint P0 A1", "P0 A0": "" },
  parallel: { "L0 L1 L2": "parallel L0 L1 L2", "EA0 L0": "parallel L0 EA0", L0: "" },
  perpendicular: { "L0 L1": "perpendicular L0 L1", "EA0 L0": "perpendicular L0 EA0", "L0 L1 L2": "" },
  tangent: { "L0 A0": "tangent L0 A0", "A0 A1": "tangent A0 A1", "L0.p2 S0.p1": "tangent L0.p2 S0.p1", "L0 L1": "" },
  equal: { "L0 L1": "equal L0 L1", "A0 A1": "equal A0 A1", "L0 A0": "" },
  collinear: { "L0 L1": "collinear L0 L1", L0: "" },
  concentric: { "A0 A1": "concentric A0 A1", "A0 EA0": "concentric A0 EA0", A0: "" },
  symmetry: {
    "P0 L0 L1.p1": "symmetry P0 L0 L1.p1",
    "A0 A1 L0": "symmetry A0 L0 A1",
    "L0 L1 L2": "symmetry L0 L2 L1",
    "P0 L0.p1 L1.p1": "symmetry P0 L1.p1 L0.p1",
    "L0 L1": "",
  },
  equal_angle: { "L0 L1 L2 L3": "equal_angle L0 L1 L2 L3", "L0 L1 L2": "" },
  smooth: { "S0.p2 L0.p1": "smooth S0.p2 L0.p1", S0: "" },
  on_normal: { "P0 L0.p1": "on_normal P0 L0.p1", P0: "" },
  lock: { "P0 L0.p1": "lock P0 L0.p1", L0: "" },
  unlock: { P0: "unlock P0", "": "" },
  fix: { "L0 A0 P0": "fix L0 A0 P0", "L0.p1": "" },
};

for (const { id, command } of CONSTRAINTS) {
  test(`${id} takes the selections that fit`, () => {
    const store = sketch();
    assert.ok(COMMANDS[id], "no selections to test");
    for (const [names, text] of Object.entries(COMMANDS[id])) {
      assert.equal(command(picked(store, names.split(" ").filter(Boolean))), text, names);
    }
  });
}

const OPERANDS = {
  length: { L0: ["L0"], "L0 L1": [], A0: [] },
  distance: { "P0 L0.p1": ["P0", "L0.p1"], "L0 P0": ["P0", "L0"], "L0 L1": ["L0", "L1"], "A0 A1": ["A0", "A1"], A0: [] },
  hdistance: { "P0 L0.p1": ["P0", "L0.p1"], "P0 L0": [] },
  vdistance: { "P0 L0.p1": ["P0", "L0.p1"] },
  radius: { A0: ["A0"], EA0: ["EA0"], L0: [] },
  diameter: { A1: ["A1"], EA0: [] },
  radius_b: { EA0: ["EA0"], A0: [] },
  angle: { "L0 L1": ["L0", "L1"], L0: [] },
  xangle: { L0: ["L0"], EA0: ["EA0"], A0: [] },
  sweep: { A1: ["A1"], A0: [] },
  arc_length: { A1: ["A1"], L0: [] },
  total_length: { "L0 L1 A1": ["L0", "L1", "A1"], L0: [] },
  area: { A0: ["A0"], "L0 L1 L2 L3": ["L0", "L1", "L2", "L3"], P0: [] },
};

for (const { id, operands } of DIMENSIONS) {
  test(`${id} takes the selections that fit`, () => {
    const store = sketch();
    assert.ok(OPERANDS[id], "no selections to test");
    for (const [names, found] of Object.entries(OPERANDS[id])) {
      assert.deepEqual(operands(picked(store, names.split(" "))), found, names);
    }
  });
}
