/** Messages, the copy of the document, drags. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { decode, encodeJson, encodePointer } from "../../arael/sketch/page/frames.js";
import { Wire } from "../../arael/sketch/page/wire.js";
import { stored } from "./sketches.js";

/** A frame of a drag as the server sends it. */
function numbers(sequence, offsets, values) {
  const at = 16 + 4 * offsets.length + ((8 - ((16 + 4 * offsets.length) % 8)) % 8);
  const buffer = new ArrayBuffer(at + 8 * values.length);
  const view = new DataView(buffer);
  [2, sequence, offsets.length, 0].forEach((n, i) => view.setUint32(4 * i, n, true));
  offsets.forEach((n, i) => view.setUint32(16 + 4 * i, n, true));
  values.forEach((n, i) => view.setFloat64(at + 8 * i, n, true));
  return buffer;
}

/** A wire whose other end is the test. */
function linked() {
  const store = stored([["L0", "line", [0, 0, 10, 0]]]);
  const sent = [];
  let handlers;
  const wire = new Wire(store, (_since, given) => {
    handlers = given;
    return { send: (buffer) => sent.push(buffer), close: () => {} };
  }, "w");
  wire.open();
  handlers.onopen();
  const reply = (message) => handlers.onmessage(encodeJson(message));
  const kinds = () => sent.map((buffer) => new DataView(buffer).getUint32(0, true));
  return { store, wire, sent, handlers, reply, kinds };
}

test("a message is its head and its payload", () => {
  const { kind, json } = decode(encodeJson({ type: "run", text: "add_point 0,0 # ä" }));
  assert.equal(kind, 1);
  assert.equal(json.text, "add_point 0,0 # ä");
  const view = new DataView(encodePointer(1.5, -2, 9));
  assert.deepEqual([view.getUint32(0, true), view.getUint32(4, true), view.getFloat64(16, true)], [3, 9, 1.5]);
  const frame = decode(numbers(4, [1, 3, 5], [7, 8, 9]));
  assert.deepEqual([[...frame.offsets], [...frame.numbers]], [[1, 3, 5], [7, 8, 9]]);
});

test("a reply reaches the command that asked", async () => {
  const { wire, sent, reply } = linked();
  const first = wire.run("one");
  const second = wire.run("two", { extras: ["horizontal _"] });
  assert.deepEqual(decode(sent[1]).json, { type: "run", text: "two", extras: ["horizontal _"], id: 2 });
  reply({ type: "reply", id: 2, ok: true, text: "second" });
  reply({ type: "reply", id: 1, ok: true, text: "first" });
  assert.equal((await first).text, "first");
  assert.equal((await second).text, "second");
});

test("while the link is lost a command is refused and nothing is queued", async () => {
  const { wire, sent, handlers } = linked();
  const waiting = wire.run("one");
  wire._closed = true;
  handlers.onclose();
  assert.equal((await waiting).ok, false);
  const before = sent.length;
  assert.match((await wire.run("two")).error.message, /lost/);
  assert.equal(sent.length, before);
});

test("of the places of a drag one is on its way, of the others the newest waits", async () => {
  const { wire, sent, kinds, handlers } = linked();
  void wire.beginDrag(["L0.p1"], [0, 0]);
  for (let x = 1; x <= 5; x++) wire.dragTo([x, 0]);
  assert.deepEqual(kinds(), [1, 3]);
  handlers.onmessage(numbers(1, [0], [1]));
  assert.deepEqual(kinds(), [1, 3, 3]);
  assert.equal(new DataView(sent[2]).getFloat64(16, true), 5);
});

test("the next place is sent before the frame of the last one is painted", () => {
  const { wire, store, kinds, handlers } = linked();
  void wire.beginDrag(["L0.p1"], [0, 0]);
  wire.dragTo([1, 0]);
  wire.dragTo([2, 0]);
  let before = [];
  store.addEventListener("values", () => (before = kinds()));
  handlers.onmessage(numbers(1, [0], [1]));
  assert.deepEqual(before, [1, 3, 3]);
});

test("a place that comes by two events is sent once", () => {
  const { wire, kinds, handlers } = linked();
  void wire.beginDrag(["L0.p1"], [0, 0]);
  wire.dragTo([1, 0]);
  wire.dragTo([1, 0]);
  handlers.onmessage(numbers(1, [0], [1]));
  wire.dragTo([1, 0]);
  assert.deepEqual(kinds(), [1, 3]);
  wire.dragTo([2, 0]);
  assert.deepEqual(kinds(), [1, 3, 3]);
});

test("a frame that answers the pointer is painted at once, others by the next refresh of the screen", () => {
  const { wire, store, handlers } = linked();
  const answers = [];
  store.addEventListener("values", (event) => answers.push(event.detail.answers));
  handlers.onmessage(numbers(0, [0], [1])); // another window drags
  void wire.beginDrag(["L0.p1"], [0, 0]);
  wire.dragTo([1, 0]);
  handlers.onmessage(numbers(1, [0], [1]));
  handlers.onmessage(numbers(1, [0], [1.5])); // the pointer rests, the frame is gone on with
  assert.deepEqual(answers, [false, true, false]);
});

test("numbers of a drag are a view: dropping it shows the document again", async () => {
  const { wire, store, handlers, reply } = linked();
  void wire.beginDrag(["L0.p1"], [0, 0]);
  wire.dragTo([1, 1]);
  handlers.onmessage(numbers(1, [0, 1], [1, 1]));
  assert.deepEqual(store.point("L0.p1"), [1, 1]);
  const dropped = wire.drop(true);
  reply({ type: "reply", id: 2, ok: true, text: "" });
  await dropped;
  assert.deepEqual(store.point("L0.p1"), [0, 0]);
});

test("a change that does not follow on what is here asks for a snapshot", () => {
  const { sent, reply, store } = linked();
  reply({ type: "change", from: 9, revision: 10, put: {}, removed: {}, offsets: [0], numbers: [3] });
  assert.deepEqual(decode(sent[0]).json, { type: "refresh" });
  assert.deepEqual(store.point("L0.p1"), [0, 0]);
});

test("a change puts, removes and moves", () => {
  const { store, reply } = linked();
  store.select(["L0", "L0.p1"]);
  const put = { entities: [{ name: "L1", kind: "line", at: 4, size: 4 }] };
  reply({ type: "change", from: 7, revision: 8, put, removed: { entities: ["L0"] }, offsets: [4, 5, 6, 7], numbers: [1, 2, 3, 4] });
  assert.deepEqual(store.point("L1.p2"), [3, 4]);
  assert.equal(store.entities.has("L0"), false);
  assert.equal(store.selection.size, 0);
});
