/** Tools as buttons: one per family, whose others open beside it. */

import { actionButton, refresh } from "./buttons.js";
import { fill, h, roving } from "./dom.js";
import { icon } from "./icons.js";

/** @typedef {import("./app.js").App} App */

/** Families of tools, the first one in front; tools that stand in none are families of their own. */
const FAMILIES = [
  { title: "rectangles", tools: ["rect", "rect3", "rectcenter"] },
  { title: "circles", tools: ["circle", "circle2", "circle3", "circle2t", "circle3t"] },
  { title: "arcs", tools: ["arc", "arc_center", "arc_tangent"] },
  { title: "ellipses", tools: ["ellipse", "earc3", "earc_center", "earc_tangent", "earc_rtangent"] },
  { title: "splines", tools: ["spline", "spline_through"] },
  { title: "shapes", tools: ["slot", "polygon", "text"] },
  { title: "corners", tools: ["fillet", "chamfer"] },
  { title: "cuts", tools: ["trim", "split", "extend"] },
  { title: "copies", tools: ["offset", "offset_line", "mirror", "pattern_circular", "pattern_rect"] },
  { title: "transforms", tools: ["move", "rotate", "scale"] },
];

/**
 * The tools as they are shown: families in the order of their first tool.
 * @param {readonly import("./types.js").ToolSpec[]} tools
 * @returns {{title: string, tools: string[], group: string}[]}
 */
export function families(tools) {
  /** @type {{title: string, tools: string[], group: string}[]} */
  const found = [];
  const seen = new Set();
  for (const { id, title, group } of tools) {
    if (seen.has(id)) continue;
    const family = FAMILIES.find((one) => one.tools.includes(id));
    const members = family ? tools.filter((one) => family.tools.includes(one.id)).map((one) => one.id) : [id];
    for (const member of members) seen.add(member);
    found.push({ title: family?.title ?? title, tools: members, group });
  }
  return found;
}

/** @param {App} app @param {HTMLElement} element */
export function mountPalette(app, element) {
  element.setAttribute("role", "toolbar");
  element.setAttribute("aria-label", "tools");
  element.setAttribute("aria-orientation", "vertical");
  const all = families(app.tools.table);
  const slots = all.map((family) => slot(app, family));
  /** @type {HTMLElement[]} */
  const parts = [];
  slots.forEach((one, i) => {
    if (i && all[i].group !== all[i - 1].group) parts.push(h("span", { class: "divider", role: "presentation" }));
    parts.push(one.element);
  });
  fill(element, ...parts);
  roving(element, ".slot > .tool, .flyout:not([hidden]) .tool", "both");
  const again = () => {
    for (const one of slots) one.show(app.tools.id);
    refresh(app, element);
  };
  app.tools.addEventListener("tool", again);
  app.root.addEventListener("pointerdown", (event) => {
    for (const one of slots) if (!one.element.contains(/** @type {Node} */ (event.target))) one.close();
  });
  again();
}

/** @param {App} app @param {{title: string, tools: string[]}} family */
function slot(app, family) {
  const element = h("div", { class: "slot" });
  let front = family.tools[0];
  const flyout = h("div", { class: "flyout", role: "group", "aria-label": family.title, hidden: true });
  const opener = h(
    "button",
    {
      class: "opener",
      "aria-label": `more ${family.title}`,
      "aria-expanded": "false",
      onclick: () => (flyout.hidden ? open() : close()),
    },
    icon("more"),
  );

  /** @param {string} id @param {boolean} [named] */
  const tool = (id, named = false) => {
    const button = actionButton(app, `tool_${id}`, "icon-button tool");
    const action = app.actions.get(`tool_${id}`);
    if (named) button.append(h("span", { class: "tool-title" }, action.title), h("kbd", {}, action.key));
    button.addEventListener("click", () => {
      close();
      app.canvas.focus();
    });
    return button;
  };
  function open() {
    fill(flyout, ...family.tools.map((id) => tool(id, true)));
    refresh(app, flyout);
    flyout.hidden = false;
    opener.setAttribute("aria-expanded", "true");
    // beside its button, also where the palette scrolls
    const box = element.getBoundingClientRect();
    const phone = window.matchMedia("(max-width: 720px)").matches;
    flyout.style.left = phone ? `${Math.min(box.left, window.innerWidth - flyout.offsetWidth - 8)}px` : `${box.right + 4}px`;
    flyout.style.top = phone
      ? `${box.top - flyout.offsetHeight - 6}px`
      : `${Math.max(Math.min(box.top, window.innerHeight - flyout.offsetHeight - 8), 8)}px`;
    /** @type {HTMLElement|null} */ (flyout.querySelector(".tool"))?.focus();
  }
  function close() {
    flyout.hidden = true;
    opener.setAttribute("aria-expanded", "false");
  }
  element.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !flyout.hidden) {
      close();
      opener.focus();
      event.stopPropagation();
    }
    if (event.key === "ArrowRight" && family.tools.length > 1 && flyout.hidden) {
      open();
      event.preventDefault();
      event.stopPropagation();
    }
  });
  element.addEventListener("contextmenu", (event) => {
    event.preventDefault();
    if (family.tools.length > 1) open();
  });

  /** @param {string} active */
  function show(active) {
    if (family.tools.includes(active)) front = active;
    fill(element, tool(front), ...(family.tools.length > 1 ? [opener, flyout] : []));
  }
  return { element, show, close };
}
