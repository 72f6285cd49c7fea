/** Curves, crossings, constructions. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { boundsOf, circle, curveOf, line, nearest, pointAt, spline, tangentAt } from "../../arael/sketch/page/geometry/curves.js";
import { arcAbout, arcTangent, arcThrough, circleThrough, circleTouching, incircle, rectangleOn } from "../../arael/sketch/page/geometry/construct.js";
import { piecesThrough } from "../../arael/sketch/page/geometry/splines.js";
import { crossings } from "../../arael/sketch/page/geometry/intersect.js";
import { chainOf } from "../../arael/sketch/page/geometry/chains.js";
import { pointHandles, pointOffset } from "../../arael/sketch/page/geometry/handles.js";
import { stored } from "./sketches.js";

const near = (a, b, tolerance = 1e-9) => assert.ok(Math.hypot(a[0] - b[0], a[1] - b[1]) < tolerance, `${a} is not ${b}`);

test("an arc runs counter-clockwise from its start to its end", () => {
  const store = stored([["A0", "arc", [0, 0, 2, 0, 0, 2, 2]]]);
  const arc = curveOf(store.entities.get("A0"), store.values);
  near(pointAt(arc, 0), [2, 0]);
  near(pointAt(arc, 0.5), [Math.SQRT2, Math.SQRT2]);
  near(tangentAt(arc, 0), [0, 1]);
});

test("start and end of an arc that was drawn clockwise are exchanged", () => {
  const store = stored([["A0", "arc", [0, 0, 2, 0, 0, 2, 2], { clockwise: true }]]);
  assert.deepEqual(store.point("A0.start"), [0, 2]);
  assert.deepEqual(store.point("A0.end"), [2, 0]);
});

test("points of a spline are its ends and poles", () => {
  const entity = { name: "S0", kind: "bspline", at: 4, size: 10 };
  assert.deepEqual(pointHandles(entity), ["S0.p1", "S0.pole2", "S0.pole3", "S0.pole4", "S0.p2"]);
  assert.equal(pointOffset(entity, "pole5"), 12);
  assert.equal(pointOffset(entity, "pole6"), -1);
});

test("the nearest point of an ellipse is perpendicular to it", () => {
  const ellipse = { type: "conic", cx: 1, cy: 2, rx: 5, ry: 1, turn: 0.3, start: 0, sweep: 2 * Math.PI, closed: true };
  for (const p of [[4, 5], [1.2, 2.1], [-6, -3], [1, 2.5]]) {
    const { at, t } = nearest(ellipse, p);
    const u = tangentAt(ellipse, t);
    assert.ok(Math.abs(u[0] * (at[0] - p[0]) + u[1] * (at[1] - p[1])) < 1e-9);
  }
});

test("the nearest point of an arc beyond its ends is an end", () => {
  const arc = arcAbout([0, 0], [1, 0], [0, 1]);
  near(nearest(arc, [2, -3]).at, [1, 0]);
});

test("a spline through points is at each, as smooth as a natural one", () => {
  const points = [[0, 0], [1, 1], [2, 0], [5, -1], [4, 3]];
  const pieces = piecesThrough(points);
  const second = ([p, q, r]) => [0, 1].map((k) => r[k] - 2 * q[k] + p[k]);
  const poles = (b) => [0, 2, 4, 6].map((i) => [b[i], b[i + 1]]);
  pieces.forEach((piece, i) => {
    const here = poles(piece);
    near(here[0], points[i]);
    near(here[3], points[i + 1]);
    if (!i) return;
    const before = poles(pieces[i - 1]);
    near([before[3][0] - before[2][0], before[3][1] - before[2][1]], [here[1][0] - here[0][0], here[1][1] - here[0][1]]);
    near(second(before.slice(1)), second(here));
  });
  near(second(poles(pieces[0])), [0, 0]);
  near(second(poles(pieces[3]).slice(1)), [0, 0]);
  // by hand: slopes 1.5, 0, -1.5 in y
  assert.deepEqual(piecesThrough(points.slice(0, 3))[0].map((x) => Math.round(6 * x) / 6), [0, 0, 1 / 3, 0.5, 2 / 3, 1, 1, 1]);
});

test("a B-spline of four poles is their Bezier curve, of more it is smooth where pieces meet", () => {
  near(pointAt(spline([[0, 0], [0, 1], [1, 1], [1, 0]]), 0.5), [0.5, 0.75]);
  const five = spline([[0, 0], [1, 2], [3, 2], [4, 0], [6, 1]]);
  near(pointAt(five, 0), [0, 0]);
  near(pointAt(five, 1), [6, 1]);
  // de Boor's value in the middle of knots 0 0 0 0 1 2 2 2 2
  near(pointAt(five, 0.5), [2.75, 1.5]);
  near(tangentAt(five, 0.5 - 1e-9), tangentAt(five, 0.5 + 1e-9), 1e-6);
});

test("bounds of an arc include the extremes that lie on it", () => {
  assert.deepEqual(boundsOf(line([3, 1], [0, 2])), { xmin: 0, ymin: 1, xmax: 3, ymax: 2 });
  const box = boundsOf(arcAbout([0, 0], [1, 0], [-1, 0]));
  near([box.ymin, box.ymax], [0, 1]);
});

test("crossings lie on both curves and within their ends", () => {
  assert.deepEqual(crossings(line([0, 0], [2, 2]), line([0, 2], [2, 0])), [[1, 1]]);
  assert.deepEqual(crossings(line([0, 0], [0.5, 0.5]), line([0, 2], [2, 0])), []);
  const two = crossings(line([-5, 1], [5, 1]), circle([0, 0], 2));
  assert.equal(two.length, 2);
  near(two[1], [Math.sqrt(3), 1]);
  assert.equal(crossings(circle([0, 0], 2), circle([3, 0], 2)).length, 2);
  assert.equal(crossings(circle([0, 0], 2), circle([0.5, 0], 1)).length, 0);
  const [at] = crossings(line([0.5, -1], [0.5, 3]), spline([[0, 0], [0, 1], [1, 1], [1, 0]]));
  near(at, [0.5, 0.75]);
});

test("an arc through three points goes from start to end past the third", () => {
  for (const through of [[0, 1], [0, -1], [0, 3]]) {
    const arc = arcThrough([1, 0], [-1, 0], through);
    near(pointAt(arc, 0), [1, 0]);
    near(pointAt(arc, 1), [-1, 0]);
    assert.ok(nearest(arc, through).distance < 1e-9);
  }
  assert.equal(arcThrough([0, 0], [2, 0], [1, 0]), null);
});

test("a tangent arc leaves in the direction of what it goes on from", () => {
  const arc = arcTangent([0, 0], [1, 0], [1, 1]);
  near(tangentAt(arc, 0), [1, 0]);
  near(pointAt(arc, 1), [1, 1]);
  assert.equal(arcTangent([0, 0], [1, 0], [2, 0]), null);
});

test("circles through points and tangent to lines", () => {
  near([circleThrough([1, 0], [0, 1], [-1, 0]).rx, 0], [1, 0]);
  const touching = circleTouching([[0, 0], [5, 0]], [[0, 0], [0, 5]], [2, 2], 1);
  near([touching.cx, touching.cy], [1, 1]);
  const inside = incircle([[[0, 0], [4, 0]], [[4, 0], [0, 3]], [[0, 3], [0, 0]]]);
  near([inside.cx, inside.rx], [1, 1]);
});

test("a rectangle on a side has right angles at any third point", () => {
  const [a, b, c, d] = rectangleOn([0, 0], [4, 2], [5, 5]);
  near([(b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]), 0], [0, 0]);
  near([d[0] - a[0], d[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
});

test("a chain is what coincident points connect", () => {
  const store = stored(
    [["L0", "line", [0, 0, 1, 0]], ["L1", "line", [1, 0, 1, 1]], ["L2", "line", [5, 5, 6, 6]]],
    [["C0", "coincident", ["L0.p2", "L1.p1"]], ["C1", "parallel", ["L1", "L2"]]],
  );
  assert.deepEqual(chainOf(store, "L0"), ["L0", "L1"]);
});
