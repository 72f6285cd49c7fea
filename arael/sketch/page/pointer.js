/** Mouse, pen and touch: places for the tool; zoom by the wheel, pan by the middle button, two fingers for both. */

import { TOLERANCE } from "./pick.js";

/**
 * @typedef {import("./types.js").Point} Point
 * @typedef {import("./types.js").Place} Place
 */

/** Pixels that a press may move and still be a click. */
const SLACK = 6;
const DOUBLE_MILLIS = 350;

export class Pointer {
  /** Fingers that are down. @type {Map<number, Point>} */
  _fingers = new Map();
  /** @type {{place: Place, button: number, moved: boolean}|null} */
  _press = null;
  /** @type {Point|null} */
  _pan = null;
  _pinched = false;
  /** The last click. */
  _last = { at: /** @type {Point} */ ([0, 0]), time: -Infinity };
  /** Whether a key holds automatic constraints off. */
  bare = false;

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    const { canvas } = app;
    canvas.addEventListener("pointerdown", (event) => this._down(event));
    // `pointermove` waits for the next refresh of the screen; a drag takes the pointer as it comes, in
    // browsers that have this event, and then need not take it twice
    let taken = 0;
    canvas.addEventListener("pointerrawupdate", (event) => {
      if (!app.drag.active || !this._press) return;
      taken = event.timeStamp;
      this._move(/** @type {PointerEvent} */ (event));
    });
    canvas.addEventListener("pointermove", (event) => event.timeStamp > taken && this._move(event));
    canvas.addEventListener("pointerup", (event) => this._up(event));
    canvas.addEventListener("pointercancel", (event) => this._cancel(event));
    canvas.addEventListener("pointerleave", (event) => this._leave(event));
    canvas.addEventListener("wheel", (event) => this._wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    // else a tap ends as a click of a mouse, which takes the focus from what the tap has opened
    canvas.addEventListener("touchend", (event) => event.cancelable && event.preventDefault(), { passive: false });
    for (const type of /** @type {const} */ (["keydown", "keyup"])) {
      app.root.addEventListener(type, (event) => this._held(event));
    }
  }

  /** Control or B leaves automatic constraints off while it is held. @param {KeyboardEvent} event */
  _held(event) {
    const { current } = this.app.tools;
    if (event.target instanceof HTMLInputElement) return;
    // a letter begins a value where one can be typed
    if (event.key.toLowerCase() === "b" && current.begun && current.fields().length) return;
    if (event.key !== "Control" && event.key.toLowerCase() !== "b") return;
    const bare = event.type === "keydown";
    if (bare === this.bare) return;
    this.bare = bare;
    if (current.place) current.move(this._placeAt(current.place.screen, bare));
  }

  /** @param {{clientX: number, clientY: number}} event @returns {Point} */
  _screen(event) {
    const { left, top } = this.app.canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  /** @param {Point} screen @param {boolean} bare */
  _placeAt(screen, bare) {
    const { tools, snapper } = this.app;
    return snapper.place(screen, tools.current.context(), { bare: bare || this.bare, free: tools.current.picks });
  }

  /** @param {PointerEvent} event */
  _place(event) {
    return this._placeAt(this._screen(event), event.ctrlKey);
  }

  /** @param {PointerEvent} event */
  _down(event) {
    const { app } = this;
    app.canvas.focus({ preventScroll: true });
    try {
      app.canvas.setPointerCapture(event.pointerId);
    } catch {
      // a pointer made by the keyboard cannot be captured
    }
    app.picker.tolerance = event.pointerType === "touch" ? TOLERANCE.touch : TOLERANCE.mouse;
    if (event.pointerType === "touch") {
      this._fingers.set(event.pointerId, this._screen(event));
      if (this._fingers.size === 2) return this._pinchBegins();
      if (this._pinched) return;
    }
    if (event.button === 1) this._pan = this._screen(event);
    else if (event.button === 0) {
      const place = this._place(event);
      this._press = { place, button: 0, moved: false };
      app.tools.current.place = place;
      app.tools.current.down(place, event);
    }
  }

  /** @param {PointerEvent} event */
  _move(event) {
    const { app } = this;
    const screen = this._screen(event);
    if (this._fingers.has(event.pointerId)) {
      if (this._fingers.size > 1) return this._pinch(event.pointerId, screen);
      this._fingers.set(event.pointerId, screen);
      if (this._pinched) return;
    }
    if (this._pan) {
      app.view.pan(screen[0] - this._pan[0], screen[1] - this._pan[1]);
      this._pan = screen;
      return;
    }
    if (this._press) {
      const [x, y] = this._press.place.screen;
      if (Math.hypot(screen[0] - x, screen[1] - y) > SLACK) this._press.moved = true;
    }
    app.tools.current.move(this._place(event), event);
  }

  /** @param {PointerEvent} event */
  _up(event) {
    const { app } = this;
    this._fingers.delete(event.pointerId);
    if (this._pinched) {
      this._pinched = this._fingers.size > 0;
      this._press = null;
      return;
    }
    if (event.button === 1) this._pan = null;
    if (event.button === 2) app.tools.current.finish();
    const press = this._press;
    if (event.button !== 0 || !press) return;
    this._press = null;
    const place = this._place(event);
    const tool = app.tools.current;
    tool.place = place;
    tool.up(place, event);
    if (tool.grabs && press.moved) return;
    if (press.moved) tool.click(press.place, event);
    this._click(place, event);
  }

  /** @param {Place} place @param {PointerEvent} event */
  _click(place, event) {
    const { at, time } = this._last;
    const near = Math.hypot(at[0] - place.screen[0], at[1] - place.screen[1]) < 2 * SLACK;
    const double = near && event.timeStamp - time < DOUBLE_MILLIS;
    this._last = { at: place.screen, time: double ? -Infinity : event.timeStamp };
    const tool = this.app.tools.current;
    if (double) tool.doubleClick(place, event);
    else tool.click(place, event);
  }

  /** @param {PointerEvent} event */
  _cancel(event) {
    this._fingers.delete(event.pointerId);
    this._press = null;
    this._pan = null;
    this.app.drag.cancel();
  }

  /** @param {PointerEvent} event */
  _leave(event) {
    const { current } = this.app.tools;
    if (this._press) return;
    this.app.store.hover([]);
    // a finger leaves after every tap: values are typed for the place where that was
    if (event.pointerType !== "touch") current.place = null;
    this.app.renderer.overlayChanged();
  }

  /** A second finger: what the first began is dropped, both pan and zoom. */
  _pinchBegins() {
    this._pinched = true;
    this._press = null;
    this.app.drag.cancel();
    this.app.tools.current.up({ at: [0, 0], snap: null, screen: [-1, -1] }, null);
  }

  /** @param {number} id @param {Point} screen */
  _pinch(id, screen) {
    const before = [...this._fingers.values()];
    this._fingers.set(id, screen);
    const after = [...this._fingers.values()];
    const [m, n] = [middle(before), middle(after)];
    const [d, e] = [span(before), span(after)];
    const { view } = this.app;
    view.pan(n[0] - m[0], n[1] - m[1]);
    if (d > 0 && e > 0) view.zoomAt(n[0], n[1], e / d);
  }

  /** @param {WheelEvent} event */
  _wheel(event) {
    event.preventDefault();
    const [x, y] = this._screen(event);
    const pixels = event.deltaMode === 1 ? 18 * event.deltaY : event.deltaY;
    // a pinch of a touch pad comes as a wheel with Control
    const factor = Math.exp(-pixels * (event.ctrlKey ? 0.01 : 0.0016));
    this.app.view.zoomAt(x, y, factor);
    const { current } = this.app.tools;
    if (current.place) current.move(this._placeAt([x, y], false), null);
  }
}

/** @param {Point[]} fingers @returns {Point} */
const middle = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];

/** @param {Point[]} fingers */
const span = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
