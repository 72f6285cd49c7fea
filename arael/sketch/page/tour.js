/** The tour at the first visit: six steps, each beside what it is about. */

import { h } from "./dom.js";
import { remember, remembered } from "./memory.js";

const KEY = "tour";

/** @type {readonly {title: string, text: string, at: string}[]} */
export const STEPS = [
  {
    title: "Draw",
    text: "Choose a tool, or press its key: R for a rectangle, L for lines, O for a circle. Click in the drawing for each point, or type the length.",
    at: "#left",
  },
  {
    title: "Snaps add constraints",
    text: "Near a point, a midpoint or a direction a mark shows what will hold. Hold Ctrl to draw without it.",
    at: "#canvas",
  },
  {
    title: "Constrain what is selected",
    text: "Click on curves and points, with Shift for several. Here are the constraints and dimensions that fit; D dimensions what you click on.",
    at: ".strip",
  },
  {
    title: "Blue is still free",
    text: "Drag something to see how it moves. This panel reports in words what can still move, and what conflicts.",
    at: ".freedoms-button, #right",
  },
  {
    title: "Values by name",
    text: "Dimensions take numbers with units, expressions and parameters: width / 2. Parameters are kept in a panel of their own.",
    at: '[data-panel="parameters"]',
  },
  {
    title: "Everything is a command",
    text: "Press / and type: add_rect 0,0 40,20 hv. Every step can be undone. Press ? for all keys.",
    at: ".field",
  },
];

export class Tour {
  at = -1;
  /** @type {HTMLElement|null} */
  element = null;

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
  }

  /** Start it at the first visit, with an empty sketch. */
  first() {
    const { store } = this.app;
    const begin = () => {
      store.removeEventListener("change", begin);
      if (!store.entities.size) this.start();
    };
    if (remembered(KEY) === null) store.addEventListener("change", begin);
  }

  start() {
    this.at = 0;
    this._show();
  }

  end() {
    remember(KEY, "seen");
    this.at = -1;
    this.element?.remove();
    this.element = null;
    for (const one of this.app.root.querySelectorAll(".tour-target")) one.classList.remove("tour-target");
    this.app.canvas.focus();
  }

  /** @param {number} by */
  _go(by) {
    this.at += by;
    if (this.at >= STEPS.length) this.end();
    else this._show();
  }

  _show() {
    const { root } = this.app;
    const { title, text, at } = STEPS[this.at];
    for (const one of root.querySelectorAll(".tour-target")) one.classList.remove("tour-target");
    const target = [...root.querySelectorAll(at)].find((one) => /** @type {HTMLElement} */ (one).offsetParent);
    target?.classList.add("tour-target");
    const last = this.at === STEPS.length - 1;
    const next = h("button", { class: "button primary", onclick: () => this._go(1) }, last ? "Done" : "Next");
    this.element?.remove();
    this.element = h(
      "div",
      { class: "tour", role: "dialog", "aria-label": "tour", "aria-live": "polite" },
      h("p", { class: "tour-count" }, `${this.at + 1} of ${STEPS.length}`),
      h("h2", {}, title),
      h("p", {}, text),
      h(
        "div",
        { class: "dialog-buttons" },
        h("button", { class: "button plain", onclick: () => this.end() }, "Skip the tour"),
        this.at ? h("button", { class: "button", onclick: () => this._go(-1) }, "Back") : null,
        next,
      ),
    );
    this.element.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      this.end();
      event.stopPropagation();
    });
    root.append(this.element);
    this._place(target);
    next.focus();
  }

  /** Beside what it is about, within the page. @param {Element|undefined} target */
  _place(target) {
    const element = /** @type {HTMLElement} */ (this.element);
    const { innerWidth, innerHeight } = window;
    const { offsetWidth: width, offsetHeight: height } = element;
    const box = target?.getBoundingClientRect() ?? new DOMRect(0, 0, innerWidth, innerHeight);
    const gap = 12;
    let x = box.left + box.width / 2 - width / 2;
    let y = box.bottom + gap;
    const large = box.width > innerWidth / 2 && box.height > innerHeight / 2;
    if (large) y = box.top + box.height / 2 - height / 2;
    else if (box.height > innerHeight / 2) {
      x = box.left < innerWidth / 2 ? box.right + gap : box.left - width - gap;
      y = box.top + gap;
    } else if (y + height > innerHeight - gap) y = box.top - height - gap;
    x = Math.min(Math.max(x, gap), innerWidth - width - gap);
    y = Math.min(Math.max(y, gap), innerHeight - height - gap);
    element.style.left = `${Math.round(x)}px`;
    element.style.top = `${Math.round(y)}px`;
  }
}
