/** Frames of a drag that are drawn before the first one, when the page has nothing else to do. */

import assert from "node:assert/strict";
import { afterEach, beforeEach, test } from "node:test";

import { rehearsal } from "../../arael/sketch/page/draw/rehearsal.js";

/** Callbacks that wait until the page has nothing to do. */
let waiting = [];

beforeEach(() => {
  waiting = [];
  globalThis.requestIdleCallback = (call) => waiting.push(call);
  globalThis.window = globalThis;
});
afterEach(() => {
  delete globalThis.requestIdleCallback;
  delete globalThis.window;
});

/** The page has nothing to do for so many frames. @param {number} frames */
function idle(frames) {
  let left = frames;
  const calls = waiting;
  waiting = [];
  for (const call of calls) call({ timeRemaining: () => (left-- > 0 ? 20 : 3) });
}

test("frames are drawn while there is time, a hundred and fifty in all", () => {
  let drawn = 0;
  const ask = rehearsal(() => ++drawn > 0);
  ask();
  ask();
  assert.equal(drawn, 0);
  assert.equal(waiting.length, 1);
  idle(25);
  assert.equal(drawn, 25);
  idle(200);
  assert.equal(drawn, 150);
  ask();
  assert.equal(waiting.length, 0);
});

test("when it cannot be drawn it waits until it is asked again", () => {
  let drawn = 0;
  let free = false;
  const ask = rehearsal(() => free && ++drawn > 0);
  ask();
  idle(10);
  assert.equal(waiting.length, 0);
  free = true;
  ask();
  idle(10);
  assert.equal(drawn, 10);
});

test("a frame that takes long is the last one", () => {
  let drawn = 0;
  const ask = rehearsal(() => {
    const end = performance.now() + 60;
    while (performance.now() < end);
    return ++drawn > 0;
  });
  ask();
  idle(10);
  ask();
  assert.deepEqual([drawn, waiting.length], [1, 0]);
});

test("a browser that does not say when it is idle draws none", () => {
  delete globalThis.requestIdleCallback;
  rehearsal(() => assert.fail())();
});
