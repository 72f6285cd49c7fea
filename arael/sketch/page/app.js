/** The application: everything that the parts of the page share. */

import { DragControl } from "./drag.js";
import { boundsOfAll, boundsOfSome, contains } from "./geometry/boxes.js";
import { Picker } from "./pick.js";
import { Pointer } from "./pointer.js";
import { Renderer } from "./draw/renderer.js";
import { Snapper } from "./snap/snapper.js";
import { Store } from "./store.js";
import { Toolbox } from "./tools/index.js";
import { View } from "./view.js";
import { Wire } from "./wire.js";

/**
 * @typedef {import("./types.js").Point} Point
 * @typedef {import("./types.js").Reply} Reply
 *
 * @typedef {object} TypingRequest  a value to be typed over the canvas
 * @property {Point} at  pixels of the canvas
 * @property {string} title  what is typed
 * @property {string} text  what stands there at first, selected
 * @property {string} [given]  the same in the unit of the part, which is meant if it stays
 * @property {import("./lengths.js").Quantity} [quantity]  plain numbers are in the unit in which it is shown
 * @property {(text: string) => Promise<Reply>} commit  an error stays in place
 * @property {(text: string) => string} [command]  what is run, to be repeated after something was taken out
 * @property {import("./failure.js").Reference} [reference]  what may be made instead where it is one too many
 * @property {() => void} [cancel]
 * @property {(text: string) => void} [change]  it is a text, not a value: called with what stands there
 * @property {boolean} [begun]  the text was begun before: the caret stands at its end
 * @property {(text: string, number: number) => void} [write]  called with what stands there, and its value if it has
 *     one; it is kept if the drawing is clicked, and must have a value when it is entered
 * @property {(step: -1|1) => void} [next]  Tab goes on to the next value
 * @property {string} [name]  of the dimension whose value it is: Tab goes on to the next one
 */

/** Pixels around geometry and around dimensions that are shown whole. */
const [AROUND, BEYOND] = [70, 24];

/** What `mountPanels` sets is null before it. */
export class App extends EventTarget {
  store = new Store();
  view = new View();
  picker = new Picker(this.store, this.view);
  snapper = new Snapper(this.store, this.view, this.picker);
  /** What is shown of the drawing. @type {Record<string, boolean>} */
  shown = { dimensions: true, glyphs: false, points: true, construction: true, regions: true };
  /** @type {import("./theme.js").Theme|null} */
  theme = null;
  /** Place for typed values. @type {import("./typing.js").Typing|null} */
  typing = null;
  /** @type {import("./notes.js").Notes|null} */
  notes = null;
  /** @type {import("./field.js").Field|null} */
  field = null;
  /** @type {import("./files.js").Files|null} */
  files = null;
  /** @type {import("./help.js").Help|null} */
  help = null;
  /** @type {import("./tour.js").Tour|null} */
  tour = null;
  /** @type {import("./panels/dock.js").Dock|null} */
  panels = null;
  /** @type {import("./keys.js").Keys|null} */
  keys = null;
  _fitted = false;

  /**
   * @param {HTMLElement} root  holds the elements of index.html
   * @param {import("./transport.js").Connect} connect
   */
  constructor(root, connect) {
    super();
    this.root = root;
    this.wire = new Wire(this.store, connect);
    this.canvas = /** @type {HTMLElement} */ (root.querySelector("#canvas"));
    /** Table of all actions. @type {import("./actions.js").Actions} */
    this.actions = /** @type {any} */ (null);
    this.renderer = new Renderer(this);
    this.picker.annotations = () => this.renderer.annotations.places;
    this.drag = new DragControl(this);
    this.tools = new Toolbox(this);
    this.pointer = new Pointer(this);
    this._follow();
  }

  /** Connect and draw. */
  start() {
    this.renderer.resize();
    this.wire.open();
  }

  /**
   * Show or hide a part of the drawing.
   * @param {string} part  of `shown`
   * @param {boolean} on
   */
  show(part, on) {
    this.shown[part] = on;
    this.renderer.annotations.shown = { dimensions: this.shown.dimensions, glyphs: this.shown.glyphs };
    this.renderer.restyled();
  }

  /** Show lengths in a unit; the part stays as it is. @param {string} unit */
  showLengths(unit) {
    this.store.lengths.set(unit);
    this.store.dispatchEvent(new CustomEvent("change", { detail: { put: {}, removed: {}, all: false } }));
  }

  /** Show everything: geometry and dimensions, clear of what lies over the drawing. */
  fit() {
    const { view, renderer, store } = this;
    const box = boundsOfAll(store);
    view.fit(box);
    if (!box) return;
    const covered = this.covered();
    // Most dimensions stand beside the geometry by a distance in pixels; those that were moved, in the sketch.
    for (let i = 0; i < 5; i++) {
      const reach = renderer.annotations.reach(renderer.ground, box);
      const [left, right, top, bottom] = [reach.left, reach.right, reach.top, reach.bottom].map((one) => Math.max(one + BEYOND, AROUND));
      view.fit(box, { left, right, top, bottom: Math.max(bottom, reach.bottom + BEYOND + covered) });
    }
  }

  /** Pixels at the bottom of the drawing that the command field covers. */
  covered() {
    const field = this.root.querySelector("#field .field")?.getBoundingClientRect();
    const canvas = this.canvas.getBoundingClientRect();
    return field?.height ? Math.max(canvas.bottom - field.top, 0) : 0;
  }

  /** Follow what a command drew out of sight. @param {readonly string[]} names */
  follow(names) {
    const box = boundsOfSome(this.store, names);
    if (box && !contains(this.view.visible, box)) this.fit();
  }

  /**
   * Run a command; what the server refuses becomes a "refused" event, for a message.
   * @param {string} text
   * @param {{extras?: string[], step?: string}} [options]
   * @returns {Promise<Reply>}
   */
  async run(text, options) {
    const reply = await this.wire.run(text, options);
    this.dispatchEvent(new CustomEvent(reply.ok ? "ran" : "refused", { detail: { text, reply } }));
    return reply;
  }

  /** Ask for a value over the canvas. @param {TypingRequest} request */
  openTyping(request) {
    this.typing?.open(request);
  }

  /** Edit the value of a dimension in place. @param {import("./types.js").Dimension} d */
  editDimension(d) {
    this.typing?.edit(d.name);
  }

  /** Edit what a text reads in place. @param {import("./types.js").Entity} frame */
  editText(frame) {
    this.typing?.editText(frame);
  }

  /** Words for the status line. @param {string} text */
  say(text) {
    this.dispatchEvent(new CustomEvent("hint", { detail: text }));
  }

  _follow() {
    const { store, view, renderer, wire } = this;
    const grid = () => (view.factor = store.lengths.factor);
    store.addEventListener("status", grid);
    store.addEventListener("change", (event) => {
      const detail = /** @type {CustomEvent} */ (event).detail;
      grid();
      this.picker.changed(detail);
      renderer.changed(detail);
      if (detail.all && !this._fitted) {
        this._fitted = true;
        this.fit();
      }
    });
    store.addEventListener("values", (event) => {
      const { offsets, answers } = /** @type {CustomEvent} */ (event).detail;
      this.picker.moved();
      renderer.moved(offsets, answers);
    });
    store.addEventListener("verdict", () => renderer.restyled());
    store.addEventListener("hover", () => renderer.overlayChanged());
    store.addEventListener("selection", () => {
      renderer.restyled();
      this.sendView();
    });
    store.addEventListener("status", (event) => this._status(/** @type {CustomEvent} */ (event).detail));
    view.addEventListener("change", () => renderer.viewChanged());
    wire.addEventListener("frame", () => renderer.late(0));
  }

  /** Tell the server what is selected here, for commands that work on the selection. */
  sendView() {
    this.wire.send({ type: "view", selection: [...this.store.selection], cursor: null });
  }

  /** @param {any} message */
  _status(message) {
    if (message.type !== "view") return;
    if (message.fit) this.fit();
    if (message.center) this.view.centre(message.center);
    if (message.zoom) this.view.zoomAt(this.view.width / 2, this.view.height / 2, message.zoom);
    if (message.cursor !== undefined) this.renderer.setCursor(message.cursor);
  }
}
