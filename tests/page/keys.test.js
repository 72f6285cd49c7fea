/** Names of keys, and the cursor that the arrow keys move. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { moved } from "../../arael/sketch/page/key_cursor.js";
import { keyName } from "../../arael/sketch/page/keys.js";

const KEYS = [
  [{ key: "l", code: "KeyL" }, "L"],
  [{ key: "R", code: "KeyR", shiftKey: true }, "Shift+R"],
  // Alt writes another character on some systems
  [{ key: "¬", code: "KeyL", altKey: true }, "Alt+L"],
  [{ key: "Å", code: "KeyA", altKey: true, shiftKey: true }, "Alt+Shift+A"],
  [{ key: "2", code: "Digit2", altKey: true, shiftKey: true }, "Alt+Shift+2"],
  [{ key: "z", code: "KeyZ", ctrlKey: true }, "Ctrl+Z"],
  [{ key: "z", code: "KeyZ", metaKey: true }, "Ctrl+Z"],
  [{ key: "Z", code: "KeyZ", ctrlKey: true, shiftKey: true }, "Ctrl+Shift+Z"],
  // the same sign with Shift or without it, as the keyboard has it
  [{ key: "?", code: "Slash", shiftKey: true }, "?"],
  [{ key: "/", code: "Digit7", shiftKey: true }, "/"],
  [{ key: "F1", code: "F1", shiftKey: true }, "Shift+F1"],
  [{ key: "Delete", code: "Delete" }, "Delete"],
  [{ key: ".", code: "Period", ctrlKey: true }, "Ctrl+."],
];

for (const [event, name] of KEYS) {
  test(`the key ${name}`, () => assert.equal(keyName(event), name));
}

test("arrow keys move by a grid step, with Shift further, with Alt by a pixel", () => {
  assert.deepEqual(moved([100, 100], "ArrowRight", {}, 12), [112, 100]);
  assert.deepEqual(moved([100, 100], "ArrowUp", {}, 12), [100, 88]);
  assert.deepEqual(moved([100, 100], "ArrowDown", { shiftKey: true }, 12), [100, 150]);
  assert.deepEqual(moved([100, 100], "ArrowLeft", { altKey: true }, 12), [99, 100]);
  assert.equal(moved([100, 100], "Enter", {}, 12), null);
});
