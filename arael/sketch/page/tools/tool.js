/** What all tools share: places, typed values, preview; one command at the end. */

import { Typed } from "./typed.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Preview} Preview
 * @typedef {import("../types.js").Field} Field
 *
 * @typedef {object} SnapContext  what is being drawn, for the snaps that need it
 * @property {Point|null} from  where the new curve began
 * @property {"line"|"point"|"none"} draws  whether tangent and perpendicular make sense
 * @property {Point[]} [extra]  places of this command, to align with
 * @property {string[]} [lines]  lines to be parallel or perpendicular to
 */

/** A tool. It gets events with places and composes commands; it never changes the document itself. */
export class Tool {
  /** @type {Place|null} */
  place = null;

  /** @param {import("../app.js").App} app */
  constructor(app) {
    this.app = app;
    this.typed = new Typed(app.store.lengths);
  }

  /** Whether pressing and moving belongs to the tool; otherwise it is two clicks. */
  get grabs() {
    return false;
  }

  /** Whether the pointer picks things: no snaps are shown. */
  get picks() {
    return false;
  }

  /** What to do next, for the status line. */
  get hint() {
    return "";
  }

  /** Whether something was begun that Escape drops. */
  get begun() {
    return false;
  }

  /** Whether something over the drawing follows the pointer. */
  get follows() {
    return true;
  }

  /** @returns {SnapContext} */
  context() {
    return { from: null, draws: "point" };
  }

  /** Values that can be typed at this step. @returns {Field[]} */
  fields() {
    return [];
  }

  /** @param {Place} place @param {PointerEvent|null} [_event] */
  move(place, _event) {
    this.place = place;
    if (this.follows) this.app.renderer.overlayChanged();
  }

  /** @param {Place} _place @param {PointerEvent|null} [_event] */
  click(_place, _event) {}

  /** @param {Place} place @param {PointerEvent|null} [_event] */
  doubleClick(place, _event) {
    this.click(place);
  }

  /** @param {Place} _place @param {PointerEvent|null} _event */
  down(_place, _event) {}

  /** @param {Place} _place @param {PointerEvent|null} _event */
  up(_place, _event) {}

  /**
   * A key that is not a typed value.
   * @param {KeyboardEvent} _event
   * @returns {boolean} whether it was used
   */
  key(_event) {
    return false;
  }

  /** A value was typed and entered. @param {string} _value */
  text(_value) {
    if (this.place) this.click(this.place);
  }

  /** Enter without a typed value, or a right click. */
  finish() {}

  /** Drop what was begun; the tool stays. */
  cancel() {
    this.typed.clear();
  }

  /** Another tool takes over. */
  leave() {
    this.cancel();
  }

  /** What to draw over the drawing. @returns {Preview} */
  preview() {
    return {};
  }

  /** Show the hint of the new step. */
  stepped() {
    this.app.say(this.hint);
    this.app.renderer.overlayChanged();
  }
}
