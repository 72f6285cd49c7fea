/** Constraints and dimensions as buttons: those that fit the selection can be used. */

import { CONSTRAINTS } from "./actions/constraints.js";
import { DIMENSIONS } from "./actions/dimensions.js";
import { actionButton, refresh } from "./buttons.js";
import { fill, h, once, roving } from "./dom.js";

/** @param {import("./app.js").App} app @param {HTMLElement} element */
export function mountStrip(app, element) {
  const group = (/** @type {readonly {id: string}[]} */ list, /** @type {string} */ label) =>
    h("div", { class: "strip-group", role: "group", "aria-label": label }, ...list.map(({ id }) => actionButton(app, id)));
  fill(
    element,
    group(CONSTRAINTS, "constraints"),
    h("span", { class: "divider", role: "presentation" }),
    group(DIMENSIONS, "dimensions"),
    h("span", { class: "divider", role: "presentation" }),
    group([{ id: "construction" }, { id: "freeze" }, { id: "delete" }], "edit"),
  );
  element.setAttribute("role", "toolbar");
  element.setAttribute("aria-label", "constraints and dimensions");
  roving(element, ".icon-button", "horizontal");
  const again = () => {
    refresh(app, element);
    // on a phone those that can be used stand first
    element.dataset.selection = String(app.store.selection.size > 0);
  };
  for (const type of ["selection", "change"]) app.store.addEventListener(type, once(again));
  again();
}
