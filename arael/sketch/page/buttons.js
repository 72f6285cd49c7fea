/** Buttons of actions: icon, tooltip with the key, greyed out while the action cannot be used. */

import { tooltip } from "./actions.js";
import { h } from "./dom.js";
import { icon } from "./icons.js";

/** @typedef {import("./app.js").App} App */

/**
 * @param {App} app
 * @param {string} id  of the action
 * @param {string} [name]  class
 * @returns {HTMLButtonElement}
 */
export function actionButton(app, id, name = "icon-button") {
  const one = app.actions.get(id);
  const props = { type: "button", class: name, title: tooltip(one), "aria-label": one.title, "data-action": id };
  return h("button", { ...props, onclick: () => app.actions.run(id) }, icon(id));
}

/**
 * Show which buttons can be used and which are on. They stay clickable: a click reports what is missing.
 * @param {App} app
 * @param {HTMLElement} element  holds them
 */
export function refresh(app, element) {
  for (const button of element.querySelectorAll("[data-action]")) {
    const one = app.actions.get(/** @type {HTMLElement} */ (button).dataset.action ?? "");
    button.setAttribute("aria-disabled", String(!app.actions.isEnabled(one)));
    if (one.checked) button.setAttribute("aria-pressed", String(one.checked(app)));
  }
}
