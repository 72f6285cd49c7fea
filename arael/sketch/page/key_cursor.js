/** Drawing without a pointer: the arrow keys move a cursor over the canvas, Enter clicks there. */

import { h } from "./dom.js";

const FINE = 1;
const COARSE = 50;
const USUAL = 10;
/** Identifies the pointer events of the keyboard. */
const KEY_POINTER = -1;

/** @type {Readonly<Record<string, [number, number]>>} */
const MOVES = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/**
 * Where the cursor goes by a key: a grid step of the sketch, a pixel with Alt, 50 pixels with Shift.
 * @param {[number, number]} at  pixels
 * @param {string} key
 * @param {{altKey?: boolean, shiftKey?: boolean}} modifiers
 * @param {number} step  pixels of a grid step
 * @returns {[number, number]|null}
 */
export function moved(at, key, modifiers, step) {
  const by = MOVES[key];
  if (!by) return null;
  const far = modifiers.altKey ? FINE : modifiers.shiftKey ? COARSE : step;
  return [at[0] + by[0] * far, at[1] + by[1] * far];
}

/** The cursor that the keys move; the canvas gets events as of a mouse. */
export class KeyCursor {
  /** @type {[number, number]|null} */
  at = null;
  /** Whether it was clicked where it is. */
  clicked = false;

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.mark = h("div", { class: "key-cursor", hidden: true });
    app.canvas.append(this.mark);
    app.canvas.addEventListener("pointermove", (event) => event.pointerId !== KEY_POINTER && this._hide());
    app.view.addEventListener("change", () => this._hide());
    app.tools.addEventListener("tool", () => (this.clicked = false));
  }

  /**
   * @param {KeyboardEvent} event
   * @param {string} name
   * @returns {boolean} whether it was used
   */
  key(event, name) {
    if (event.ctrlKey || event.metaKey) return false;
    const next = moved(this.place(), event.key, event, this.step());
    if (next) {
      this.move(next);
      return true;
    }
    if (name !== "Enter" && name !== "Shift+Enter") return false;
    const { current, id } = this.app.tools;
    if (current.typed.any) return false;
    if (!this.at) {
      if (id === "select" || current.begun) return false;
      this.move(this.place());
    }
    // twice at one place finishes what is drawn
    if (this.clicked && current.begun) return false;
    this.click(event.shiftKey);
    return true;
  }

  /** Pixels of a grid step, so that the cursor stays on the grid. */
  step() {
    const { view } = this.app;
    return view.grid ? view.gridStep() * view.scale : USUAL;
  }

  /** Where it is: at first in the middle, on the grid. @returns {[number, number]} */
  place() {
    if (this.at) return this.at;
    const { view, tools } = this.app;
    const last = tools.current.place;
    if (last) return [last.screen[0], last.screen[1]];
    const step = view.gridStep();
    const [x, y] = view.toWorld([view.width / 2, view.height / 2]);
    return view.toScreen([Math.round(x / step) * step, Math.round(y / step) * step]);
  }

  /** @param {[number, number]} to */
  move(to) {
    const { view } = this.app;
    this.at = [Math.min(Math.max(to[0], 0), view.width), Math.min(Math.max(to[1], 0), view.height)];
    this.clicked = false;
    this.mark.hidden = false;
    this.mark.style.transform = `translate(${this.at[0]}px, ${this.at[1]}px)`;
    this._send("pointermove", 0, false);
  }

  _hide() {
    // to hide what is hidden costs the page's style, for each move of the mouse
    if (!this.at) return;
    this.at = null;
    this.mark.hidden = true;
  }

  /** @param {boolean} shiftKey */
  click(shiftKey) {
    this._send("pointerdown", 1, shiftKey);
    this._send("pointerup", 0, shiftKey);
    this.clicked = true;
  }

  /** @param {string} type @param {number} buttons @param {boolean} shiftKey */
  _send(type, buttons, shiftKey) {
    const [x, y] = this.at ?? [0, 0];
    const box = this.app.canvas.getBoundingClientRect();
    const init = {
      bubbles: true,
      cancelable: true,
      pointerId: KEY_POINTER,
      pointerType: "mouse",
      isPrimary: true,
      clientX: box.left + x,
      clientY: box.top + y,
      button: type === "pointermove" ? -1 : 0,
      buttons,
      shiftKey,
    };
    this.app.canvas.dispatchEvent(new PointerEvent(type, init));
  }
}
