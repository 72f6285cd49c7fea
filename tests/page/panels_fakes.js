/** Stand-ins for tests of the panels: a store that holds a small sketch. */

import { Store } from "../../arael/sketch/page/store.js";

/** A rectangle, two circles, a point; constraints, dimensions, a parameter. */
export function sketch() {
  const store = new Store();
  const line = (name, at) => ({ name, kind: "line", at, size: 4 });
  const entities = [
    line("L0", 0),
    line("L1", 4),
    line("L2", 8),
    line("L3", 12),
    { name: "A0", kind: "circle", at: 16, size: 3 },
    { name: "A1", kind: "arc", at: 19, size: 7 },
    { name: "P0", kind: "point", at: 26, size: 2 },
    { name: "EA0", kind: "ellipse", at: 28, size: 5 },
    { name: "S0", kind: "bezier", at: 33, size: 8 },
  ];
  store.receive({
    type: "snapshot",
    revision: 1,
    document: {
      entities,
      constraints: [
        { name: "C0", kind: "coincident", args: ["L0.p2", "L1.p1"], active: true },
        { name: "CL0H", kind: "horizontal", args: ["L0"], active: true },
        { name: "C4", kind: "parallel", args: ["L0", "L2"], active: false },
      ],
      dimensions: [
        { name: "d0", kind: "length", args: ["L0"], value: { text: "width / 2", number: 5 }, broken: "" },
        { name: "d1", kind: "radius", args: ["A0"], value: { text: "2", number: 2 }, broken: "no parameter w" },
      ],
      parameters: [{ name: "width", amount: { text: "10", number: 10 }, broken: "" }],
      groups: [{ name: "M0", kind: "polygon", results: ["L2", "L3"] }],
    },
    values: Array.from({ length: 41 }, (_, i) => i),
    settings: {},
  });
  return store;
}
