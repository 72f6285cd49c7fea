/** The panels as tabs: beside the drawing, on a phone a sheet from below. */

import { PANELS } from "../actions/viewing.js";
import { fill, h, roving } from "../dom.js";
import { icon } from "../icons.js";
import { remember, remembered } from "../memory.js";
import { mount as freedom } from "./freedom.js";
import { mount as history } from "./history.js";
import { mount as parameters } from "./parameters.js";
import { mount as relations } from "./relations.js";
import { mount as selection } from "./selection.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {(app: App, element: HTMLElement) => {show(): void}} Mount
 */

/** @type {Readonly<Record<string, Mount>>} */
const MOUNTS = { selection, parameters, relations, freedom, history };
const KEY = "panel";
export const PHONE = "(max-width: 720px)";

export class Dock {
  open = "";
  /** @type {Map<string, {tabs: HTMLElement[], element: HTMLElement, panel: {show(): void}}>} */
  panels = new Map();

  /**
   * @param {App} app
   * @param {HTMLElement} side  holds the panels
   * @param {HTMLElement} bottom  holds the tabs on a phone
   */
  constructor(app, side, bottom) {
    this.app = app;
    this.side = side;
    this.phone = window.matchMedia(PHONE);
    const above = h("div", { class: "tabs", role: "tablist", "aria-label": "panels" });
    const below = h("div", { class: "tabs", role: "tablist", "aria-label": "panels" });
    const body = h("div", { class: "panel-body" });
    for (const { id, title, key } of PANELS) {
      const element = h("section", {
        class: `panel panel-${id}`,
        id: `panel-${id}`,
        role: "tabpanel",
        "aria-label": title,
        hidden: true,
      });
      const tabs = [above, below].map((list) => {
        const tab = this._tab(id, title, key);
        list.append(tab);
        return tab;
      });
      body.append(element);
      this.panels.set(id, { tabs, element, panel: MOUNTS[id](app, element) });
    }
    for (const list of [above, below]) roving(list, ".tab", "horizontal");
    fill(side, above, body);
    fill(bottom, below);
    const first = remembered(KEY);
    if (this.phone.matches) this.show("");
    else this.show(first !== null && (first === "" || this.panels.has(first)) ? first : "selection");
    this.phone.addEventListener("change", () => this.show(this.phone.matches ? "" : "selection"));
    app.store.addEventListener("verdict", () => this._count());
    this._grip();
  }

  /** Whether a panel is seen. @param {string} id */
  isOpen(id) {
    return this.open === id;
  }

  /** Show a panel, "" shows none. @param {string} id */
  show(id) {
    this.open = id;
    if (!this.phone.matches) remember(KEY, id);
    this.side.dataset.open = String(id !== "");
    this.app.root.dataset.panel = id;
    for (const [name, { tabs, element, panel }] of this.panels) {
      element.hidden = name !== id;
      for (const tab of tabs) {
        tab.setAttribute("aria-selected", String(name === id));
        tab.tabIndex = name === id || (id === "" && name === "selection") ? 0 : -1;
      }
      if (name === id) panel.show();
    }
  }

  /** Show a panel and go there, or close it if it is seen. @param {string} id */
  toggle(id) {
    const closes = this.open === id;
    this.show(closes ? "" : id);
    if (closes) this.app.canvas.focus();
    else this.panels.get(id)?.tabs.find((tab) => tab.offsetParent)?.focus();
  }

  /** @param {string} id @param {string} title @param {string} key */
  _tab(id, title, key) {
    return h(
      "button",
      {
        class: "tab",
        type: "button",
        role: "tab",
        "data-panel": id,
        "aria-controls": `panel-${id}`,
        title: `${title} (${key})`,
        onclick: () => (this.open === id ? this.show("") : this.show(id)),
      },
      icon(`panel_${id}`),
      h("span", { class: "tab-title" }, title),
      id === "freedom" ? h("span", { class: "badge", hidden: true }) : null,
    );
  }

  /** The number of conflicts on the tab. */
  _count() {
    const count = Object.values(this.app.store.verdict.constraints).filter((state) => state !== "here").length;
    for (const tab of this.panels.get("freedom")?.tabs ?? []) {
      const badge = /** @type {HTMLElement} */ (tab.querySelector(".badge"));
      badge.hidden = count === 0;
      badge.textContent = String(count);
    }
  }

  /** On a phone a swipe down closes the sheet. */
  _grip() {
    let from = 0;
    const body = /** @type {HTMLElement} */ (this.side.querySelector(".panel-body"));
    this.side.addEventListener("touchstart", (event) => (from = event.touches[0].clientY), { passive: true });
    this.side.addEventListener(
      "touchend",
      (event) => {
        const by = event.changedTouches[0].clientY - from;
        if (this.phone.matches && by > 60 && body.scrollTop === 0) this.show("");
      },
      { passive: true },
    );
  }
}
