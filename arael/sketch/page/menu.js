/** Menus of the top bar, made from the table of actions. */

import { FORMATS, SHEETS } from "./actions/filing.js";
import { LAYERS } from "./actions/viewing.js";
import { fill, h, roving } from "./dom.js";
import { icon } from "./icons.js";
import { UNITS } from "./lengths.js";
import { askPartUnit } from "./part_unit.js";

/**
 * @typedef {import("./app.js").App} App
 *
 * @typedef {object} Item
 * @property {string} title
 * @property {string} [key]
 * @property {boolean} [checked]
 * @property {boolean} [enabled]
 * @property {string} [role]
 * @property {() => unknown} run
 */

const THEMES = [
  { id: "auto", title: "Theme as the system" },
  { id: "light", title: "Light" },
  { id: "dark", title: "Dark" },
];

/** @param {App} app @param {string} id @returns {Item} */
function action(app, id) {
  const one = app.actions.get(id);
  return {
    title: one.title,
    key: one.key,
    checked: one.checked?.(app),
    enabled: app.actions.isEnabled(one),
    run: () => app.actions.run(id),
  };
}

/** Items of each menu, null for a line between them. @type {Readonly<Record<string, (app: App) => (Item|null)[]>>} */
const MENUS = {
  File: (app) => [
    action(app, "save"),
    action(app, "import"),
    null,
    ...FORMATS.map(({ id }) => action(app, `export_${id}`)),
    null,
    ...SHEETS.map((sheet) => action(app, `export_${sheet.toLowerCase()}`)),
  ],
  Edit: (app) => [
    action(app, "undo"),
    action(app, "redo"),
    null,
    action(app, "select_all"),
    action(app, "deselect"),
    action(app, "delete"),
    null,
    action(app, "construction"),
    action(app, "quiet"),
    action(app, "freeze"),
    action(app, "switch_off"),
    action(app, "switch_on"),
    null,
    { title: `Unit of the part: ${app.store.unit} ...`, run: () => askPartUnit(app) },
  ],
  View: (app) => [
    action(app, "fit"),
    action(app, "grid"),
    ...LAYERS.map(({ id }) => action(app, `show_${id}`)),
    null,
    ...UNITS.map((unit) => ({
      title: `Lengths in ${unit}${unit === app.store.unit ? ", as the part" : ""}`,
      checked: app.store.lengths.name === unit,
      role: "menuitemradio",
      run: () => app.showLengths(unit),
    })),
    null,
    ...THEMES.map(({ id, title }) => ({
      title,
      checked: app.theme?.name === id,
      role: "menuitemradio",
      run: () => app.theme?.set(/** @type {import("./theme.js").ThemeName} */ (id)),
    })),
  ],
  Help: (app) => [action(app, "manual"), action(app, "keys"), action(app, "tour")],
};

/** @param {App} app @param {HTMLElement} element */
export function mountMenus(app, element) {
  const menus = Object.entries(MENUS).map(([title, items]) => menu(app, title, items));
  fill(element, ...menus);
  element.setAttribute("role", "menubar");
  element.setAttribute("aria-label", "menus");
  roving(element, ".menu-title", "horizontal");
}

/** @param {App} app @param {string} title @param {(app: App) => (Item|null)[]} items */
function menu(app, title, items) {
  const list = h("div", { class: "menu", role: "menu", "aria-label": title, hidden: true });
  const button = h(
    "button",
    {
      class: "menu-title",
      role: "menuitem",
      "aria-haspopup": "menu",
      "aria-expanded": "false",
      onclick: () => (list.hidden ? open() : close()),
    },
    title,
  );
  const element = h("div", { class: "menu-holder" }, button, list);

  function open() {
    fill(list, ...items(app).map((item) => (item ? entry(app, item, close) : h("hr", {}))));
    list.hidden = false;
    button.setAttribute("aria-expanded", "true");
    /** @type {HTMLElement|null} */ (list.querySelector(".menu-item"))?.focus();
  }
  function close() {
    list.hidden = true;
    button.setAttribute("aria-expanded", "false");
  }
  roving(list, ".menu-item");
  element.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !list.hidden) {
      close();
      button.focus();
      event.stopPropagation();
    } else if (event.key === "ArrowDown" && list.hidden) {
      open();
      event.preventDefault();
      event.stopPropagation();
    } else if (!list.hidden && (event.key === "ArrowLeft" || event.key === "ArrowRight")) {
      const step = event.key === "ArrowLeft" ? "previousElementSibling" : "nextElementSibling";
      const next = /** @type {HTMLElement|null} */ (element[step]?.querySelector(".menu-title") ?? null);
      if (next) {
        close();
        next.focus();
        next.click();
      }
      event.preventDefault();
      event.stopPropagation();
    }
  });
  element.addEventListener("focusout", (event) => {
    if (!element.contains(/** @type {Node|null} */ (event.relatedTarget))) close();
  });
  return element;
}

/** @param {App} app @param {Item} item @param {() => void} close */
function entry(app, item, close) {
  const role = item.role ?? (item.checked === undefined ? "menuitem" : "menuitemcheckbox");
  const run = () => {
    close();
    app.canvas.focus();
    item.run();
  };
  return h(
    "button",
    {
      class: "menu-item",
      role,
      "aria-checked": item.checked === undefined ? null : String(item.checked),
      "aria-disabled": item.enabled === false ? "true" : null,
      onclick: run,
    },
    h("span", { class: "menu-check" }, item.checked ? icon("check") : null),
    h("span", { class: "menu-text" }, item.title),
    item.key ? h("kbd", {}, item.key) : null,
  );
}

/** Groups of actions in the menu of the drawing. */
const ON_SELECTION = ["edit", "constrain", "dimension"];
/** Where nothing is selected. */
const ON_NOTHING = ["undo", "redo", null, "select_all", "fit", "grid", "show_glyphs"];

/** What fits the selection, in groups with lines between them. @param {App} app @returns {(Item|null)[]} */
export function fitting(app) {
  if (!app.store.selection.size) return ON_NOTHING.map((id) => (id ? action(app, id) : null));
  /** @type {(Item|null)[]} */
  const items = [];
  for (const group of ON_SELECTION) {
    const fits = app.actions.list.filter((one) => one.group === group && (one.needs || one.id === "delete") && app.actions.isEnabled(one));
    if (fits.length && items.length) items.push(null);
    items.push(...fits.map((one) => action(app, one.id)));
  }
  return items;
}

/** A menu at a place of the drawing, of what fits what is selected. @param {App} app @param {[number, number]} at  pixels of the canvas */
export function openFitting(app, [x, y]) {
  const { canvas, view } = app;
  const list = h("div", { class: "menu at-pointer", role: "menu", "aria-label": "what fits the selection", tabindex: -1 });
  let open = true;
  const close = () => {
    // to remove it takes its focus, which closes it, too
    if (open) {
      open = false;
      list.remove();
    }
  };
  fill(list, ...fitting(app).map((item) => (item ? entry(app, item, close) : h("hr", {}))));
  roving(list, ".menu-item");
  list.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    close();
    canvas.focus();
    event.stopPropagation();
  });
  list.addEventListener("focusout", (event) => {
    if (!list.contains(/** @type {Node|null} */ (event.relatedTarget))) close();
  });
  canvas.parentElement?.append(list);
  list.style.left = `${Math.max(Math.min(x, view.width - list.offsetWidth - 4), 4)}px`;
  list.style.top = `${Math.max(Math.min(y, view.height - list.offsetHeight - 4), 4)}px`;
  /** @type {HTMLElement|null} */ (list.querySelector(".menu-item"))?.focus();
}
