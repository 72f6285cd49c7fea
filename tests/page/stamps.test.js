/** Marks of points: drawn once for each place between pixels, then copied. */

import assert from "node:assert/strict";
import { afterEach, test } from "node:test";

import { drawMarks } from "../../arael/sketch/page/draw/stamps.js";

const LOOK = /** @type {const} */ ({ shape: "ring", r: 2.7, colour: "#123456", back: "#ffffff" });

/** A canvas that notes what is drawn. */
function canvas(ratio) {
  const drawn = [];
  const ctx = {
    drawn, arcs: 0, scale: ratio,
    getTransform: () => ({ a: ctx.scale }),
    setTransform: (given) => (ctx.scale = given.a),
    resetTransform: () => (ctx.scale = 1),
    drawImage: (image, x, y) => drawn.push([image, x, y, ctx.scale]),
    beginPath() {}, fill() {},
    arc: () => ctx.arcs++,
  };
  return ctx;
}

/** Give the page images; returns where the middle of each image's mark is in it. */
function withImages() {
  const made = [];
  globalThis.OffscreenCanvas = class {
    constructor(width) {
      this.image = { width };
    }

    getContext() {
      const { image } = this;
      return {
        setTransform: (a, b, c, d, x, y) => Object.assign(image, { ratio: a, x, y }),
        beginPath() {}, fill() {}, arc() {},
      };
    }

    transferToImageBitmap() {
      made.push(this.image);
      return this.image;
    }
  };
  return made;
}

afterEach(() => delete globalThis.OffscreenCanvas);

test("marks stand within an eighth of a pixel of their places, at whole pixels of the screen", () => {
  const made = withImages();
  for (const ratio of [1, 1.5, 2]) {
    const ctx = canvas(ratio);
    const places = Array.from({ length: 400 }, (_, i) => (i * 0.737) % 91 - 5);
    drawMarks(ctx, LOOK, places);
    assert.equal(ctx.drawn.length, 200);
    assert.equal(ctx.scale, ratio);
    ctx.drawn.forEach(([image, x, y, scale], i) => {
      assert.equal(scale, 1);
      assert.ok(Number.isInteger(x) && Number.isInteger(y));
      assert.equal(image.ratio, ratio);
      assert.ok(Math.abs(x + image.x - ratio * places[2 * i]) <= 0.125 + 1e-9);
      assert.ok(Math.abs(y + image.y - ratio * places[2 * i + 1]) <= 0.125 + 1e-9);
      assert.ok(image.x - 6 * ratio > 0 && image.x + 6 * ratio < image.width);
    });
  }
  assert.ok(made.length <= 48, `${made.length} images`);
});

test("marks of another colour are other images", () => {
  withImages();
  const [one, other] = [canvas(1), canvas(1)];
  drawMarks(one, LOOK, [3, 4]);
  drawMarks(other, { ...LOOK, colour: "#abcdef" }, [3, 4]);
  assert.notEqual(one.drawn[0][0], other.drawn[0][0]);
});

test("without images every mark is drawn by itself", () => {
  const ctx = canvas(1);
  drawMarks(ctx, LOOK, [3, 4, 5, 6]);
  assert.equal(ctx.drawn.length, 0);
  assert.equal(ctx.arcs, 4);
});
