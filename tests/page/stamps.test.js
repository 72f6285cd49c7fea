/** Marks of points: drawn once for each place between pixels, then laid on a drawing by hand. */

import assert from "node:assert/strict";
import { after, test } from "node:test";

import { stampMarks } from "../../arael/sketch/page/draw/stamps.js";

const LOOK = /** @type {const} */ ({ shape: "ring", r: 2.7, colour: "#123456", back: "#ffffff" });

const made = { count: 0 };

// the page keeps the small canvas on which it draws: its first pixels say how a mark was drawn
globalThis.OffscreenCanvas = class {
  getContext() {
    const canvas = this;
    let placed = [0, 0, 0];
    return {
      canvas,
      setTransform: (a, b, c, d, x, y) => (placed = [a, x, y]),
      beginPath() {}, fill() {}, arc() {},
      getImageData: (x, y, size) => {
        made.count++;
        const data = new Int32Array(size * size);
        data.set([canvas.width, ...placed.map((one) => Math.round(1e4 * one))], 1);
        return { data: new Uint8ClampedArray(data.buffer) };
      },
    };
  }
};

/** A sheet that notes what is laid on it. */
function sheet(ratio = 1) {
  const laid = [];
  return { laid, ratio, stamp: (dots, left, top) => laid.push([dots, left, top]) };
}

after(() => delete globalThis.OffscreenCanvas);

test("marks stand within an eighth of a pixel of their places", () => {
  for (const ratio of [1, 1.5, 2]) {
    const on = sheet(ratio);
    const { laid } = on;
    const places = Float64Array.from({ length: 800 }, (_, i) => (Math.floor(i / 4) * 1.474 + (i % 2) * 0.737) % 91 - 5);
    stampMarks(/** @type {any} */ (on), LOOK, places, 200);
    assert.equal(laid.length, 200);
    laid.forEach(([dots, left, top], i) => {
      assert.ok(Number.isInteger(left) && Number.isInteger(top));
      const [width, drawn, x, y] = [2, 6, 10, 14].map((k) => dots[k]);
      assert.equal(drawn, 1e4 * ratio);
      assert.ok(Math.abs(left + x / 1e4 - ratio * places[4 * i]) <= 0.125 + 1e-9);
      assert.ok(Math.abs(top + y / 1e4 - ratio * places[4 * i + 1]) <= 0.125 + 1e-9);
      assert.ok(x / 1e4 - 6 * ratio > 0 && x / 1e4 + 6 * ratio < width);
    });
  }
  assert.ok(made.count <= 48, `${made.count} images`);
});

test("marks of another colour are other images", () => {
  const [one, other] = [sheet(), sheet()];
  stampMarks(/** @type {any} */ (one), LOOK, Float64Array.of(3, 4, 3, 4), 1);
  stampMarks(/** @type {any} */ (other), { ...LOOK, colour: "#abcdef" }, Float64Array.of(3, 4, 3, 4), 1);
  assert.notEqual(one.laid[0][0], other.laid[0][0]);
});
