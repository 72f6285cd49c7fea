/** Dark, light, or as the system: kept in the browser. */

import { remember, remembered } from "./memory.js";

/** @typedef {"auto"|"light"|"dark"} ThemeName */

/** @type {readonly ThemeName[]} */
const THEMES = ["auto", "light", "dark"];
const KEY = "theme";

/** Event: "change". */
export class Theme extends EventTarget {
  /** @param {HTMLElement} root  the document's element, which gets `data-theme` */
  constructor(root) {
    super();
    this.root = root;
    /** @type {ThemeName} */
    this.name = THEMES.find((one) => one === remembered(KEY)) ?? "auto";
    this._apply();
    const system = window.matchMedia("(prefers-color-scheme: dark)");
    system.addEventListener("change", () => this.dispatchEvent(new Event("change")));
  }

  /** @param {ThemeName} name */
  set(name) {
    this.name = name;
    remember(KEY, name);
    this._apply();
    this.dispatchEvent(new Event("change"));
  }

  /** The next one of auto, light, dark. */
  next() {
    this.set(THEMES[(THEMES.indexOf(this.name) + 1) % THEMES.length]);
  }

  _apply() {
    if (this.name === "auto") delete this.root.dataset.theme;
    else this.root.dataset.theme = this.name;
  }
}
