/** Drawings by hand: how much of each pixel is covered, and how colours lie on each other. */

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { Sheet } from "../../arael/sketch/page/draw/sheet.js";
import { Swept } from "../../arael/sketch/page/draw/swept.js";

const [WIDTH, HEIGHT] = [200, 150];
/** As numbers of pixels have them: alpha, blue, green, red. */
const [RED, BLUE] = [0xff0000ff | 0, 0xffff0000 | 0];

before(() => {
  globalThis.ImageData = class {
    constructor(data, width, height) {
      Object.assign(this, { data, width, height });
    }
  };
});
after(() => {
  delete globalThis.ImageData;
  delete globalThis.OffscreenCanvas;
});

/** Have canvases that show one colour without holes. @param {number[]} rgb */
function grounds(rgb) {
  globalThis.OffscreenCanvas = class {
    getContext() {
      const getImageData = (x, y, w, h) => ({ data: Uint8ClampedArray.from({ length: 4 * w * h }, (_, i) => [...rgb, 255][i % 4]) });
      return { canvas: this, drawImage() {}, getImageData };
    }
  };
}

/** One line, as of a list of several. */
const line = (sheet, [...ends], width, colour) => sheet.lines(Float64Array.from(ends), 1, width, colour);

/** Draw, and put it on a canvas: red, green, blue, alpha at a place. @param {(sheet: Sheet) => void} draw */
function drawn(draw, sheet = new Sheet()) {
  const pixels = new Map();
  const swept = new Swept();
  sheet.begin(WIDTH, HEIGHT, 1);
  swept.begin(WIDTH, HEIGHT);
  swept.addAll();
  draw(sheet);
  const putImageData = ({ data, width }, dx, dy, x, y, w, h) => {
    for (let j = y; j < y + h; j++) {
      for (let i = x; i < x + w; i++) {
        const at = 4 * (j * width + i);
        pixels.set(`${dx + i} ${dy + j}`, [...data.subarray(at, at + 4)]);
      }
    }
  };
  sheet.put(/** @type {any} */ ({ putImageData }), swept);
  return (/** @type {number} */ x, /** @type {number} */ y) => pixels.get(`${x} ${y}`);
}

/** Share of a pixel inside of a line, by trial; `slope`: by how much it is wider on each side further along. */
function covered([x1, y1, x2, y2, width], x, y, slope = 0) {
  const long = Math.hypot(x2 - x1, y2 - y1);
  const [ux, uy] = [(x2 - x1) / long, (y2 - y1) / long];
  let count = 0;
  for (let k = 0; k < 400; k++) {
    const [dx, dy] = [x + ((k % 20) + 0.5) / 20 - x1, y + (Math.floor(k / 20) + 0.5) / 20 - y1];
    const along = dx * ux + dy * uy;
    if (Math.abs(dx * uy - dy * ux) < width / 2 + slope * along && along > 0 && along < long) count++;
  }
  return count / 400;
}

test("a line covers each pixel by its area", () => {
  const lines = [
    [10.3, 20.2, 90.6, 20.2, 1.7], [70.45, 130, 70.45, 8.2, 2.1], [5, 5, 120, 64.5, 1.7], [150.2, 140.1, 100, 3, 2.1],
    [190, 20, 20, 33, 3.4], [60, 60, 63, 64, 1.1], [-30, 40, 300, 41.3, 1.7],
    [20, 30.4, 120, 30.415, 1.7], [80.3, 120, 80.285, 10, 1.7],
  ];
  for (const one of lines) {
    const at = drawn((sheet) => line(sheet, one.slice(0, 4), one[4], RED));
    for (let y = 0; y < HEIGHT; y++) {
      for (let x = 0; x < WIDTH; x++) {
        const alpha = at(x, y)[3] / 255;
        // where the corner of an end is, both edges are multiplied
        assert.ok(Math.abs(alpha - covered(one, x, y)) < 0.09, `${one}: ${x}, ${y}: ${alpha}`);
      }
    }
  }
});

test("an arrow covers each pixel by its area, in any direction", () => {
  for (let turn = 0; turn < 32; turn++) {
    const angle = (turn * Math.PI) / 16;
    const one = [100.3, 70.6, 100.3 + 9 * Math.cos(angle), 70.6 + 9 * Math.sin(angle), 0];
    const at = drawn((sheet) => sheet.arrows(one.slice(0, 4), 0.28, RED));
    let [sum, all] = [0, 0];
    for (let y = 55; y < 86; y++) {
      for (let x = 85; x < 116; x++) {
        const [alpha, wanted] = [at(x, y)[3] / 255, covered(one, x, y, 0.28)];
        // at its corners edges are multiplied
        assert.ok(Math.abs(alpha - wanted) < 0.2, `${turn}: ${x}, ${y}: ${alpha}, not ${wanted}`);
        sum += Math.abs(alpha - wanted);
        all += alpha;
      }
    }
    assert.ok(sum < 0.05 * all && Math.abs(all - 0.28 * 81) < 0.6, `${turn}: ${sum} of ${all}`);
  }
});

test("a line is drawn between its ends only, and nowhere without a place", () => {
  const at = drawn((sheet) => {
    line(sheet, [NaN, 4, 5, 9], 2, RED);
    line(sheet, [-1e9, -5, 1e9, -5], 2, RED);
    line(sheet, [40, 40, 60, 40], 2, RED);
  });
  let sum = 0;
  for (let y = 0; y < HEIGHT; y++) for (let x = 0; x < WIDTH; x++) sum += at(x, y)[3];
  assert.equal(sum, 255 * 40);
});

test("what is laid later is in front, in part where it covers in part", () => {
  const at = drawn((sheet) => {
    line(sheet, [10, 50, 100, 50], 10, RED);
    line(sheet, [50, 10, 50, 100], 10.5, BLUE);
    sheet.stamp(Int32Array.of(0, 0, 0xff0000, 255, 1, 0, 0xff0000, 128), 20, 50);
  });
  assert.deepEqual(at(30, 50), [255, 0, 0, 255]);
  assert.deepEqual(at(50, 50), [0, 0, 255, 255]);
  assert.deepEqual(at(44, 50), [191, 0, 64, 255]);
  assert.deepEqual(at(44, 20), [0, 0, 255, 64]);
  assert.deepEqual(at(20, 50), [0, 0, 255, 255]);
  assert.deepEqual(at(21, 50), [127, 0, 128, 255]);
});

test("lines are given by other pixels than those of the screen", () => {
  const ends = Float64Array.of(0, 0, 1, 1, 10, 25, 50, 25, 35, 5, 35, 50);
  const at = drawn((sheet) => {
    sheet.begin(WIDTH, HEIGHT, 2);
    sheet.lines(ends.subarray(4), 2, 5, RED);
  });
  for (const [x, y, alpha] of [[30, 50, 255], [30, 44, 0], [30, 45, 255], [18, 50, 0], [70, 99, 255], [76, 20, 0]]) {
    assert.equal(at(x, y)[3], alpha, `${x} ${y}`);
  }
});

test("one colour twice covers more, and a drawing begins empty", () => {
  const sheet = new Sheet();
  const at = drawn((one) => {
    line(one, [10, 50, 100, 50], 0.5, RED);
    line(one, [10, 50, 100, 50], 0.5, RED);
  }, sheet);
  assert.deepEqual(at(20, 49), [255, 0, 0, 112]);
  assert.deepEqual(drawn(() => {}, sheet)(20, 49), [0, 0, 0, 0]);
});

test("over a ground the share of a colour is that of the pixel, and the ground is there again afterwards", () => {
  const [red, green, blue] = [200, 17, 90];
  grounds([red, green, blue]);
  const sheet = new Sheet();
  const below = /** @type {any} */ ({});
  sheet.begin(WIDTH, HEIGHT, 1);
  sheet.lay(below);
  assert.equal(sheet.below, below);
  const dots = Array.from({ length: 256 }, (_, alpha) => [alpha % 16, Math.floor(alpha / 16), 0x20c805, alpha]).flat();
  const at = drawn((one) => one.stamp(Int32Array.from(dots), 60, 20), sheet);
  for (let alpha = 0; alpha < 256; alpha++) {
    const found = at(60 + (alpha % 16), 20 + Math.floor(alpha / 16));
    const wanted = [[5, red], [200, green], [32, blue]].map(([over, under]) => under + ((over - under) * alpha) / 255);
    wanted.forEach((one, k) => assert.ok(Math.abs(found[k] - one) < 1.3, `${alpha}: ${found}, not ${wanted}`));
    assert.equal(found[3], 255);
  }
  assert.deepEqual(at(199, 149), [red, green, blue, 255]);
  assert.deepEqual(drawn(() => {}, sheet)(60, 35), [red, green, blue, 255]);
  sheet.lay(null);
  assert.deepEqual(drawn((one) => line(one, [10, 50, 100, 50], 0.5, RED), sheet)(20, 49), [255, 0, 0, 64]);
  assert.deepEqual(drawn(() => {}, sheet)(60, 35), [0, 0, 0, 0]);
});
