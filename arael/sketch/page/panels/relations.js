/** Constraints and dimensions with search and filter: select, switch on and off, edit, delete. */

import { fill, h, once } from "../dom.js";
import { quantityOf } from "../draw/texts.js";
import { icon } from "../icons.js";
import { points } from "../mention.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../types.js").Constraint} Constraint
 * @typedef {import("../types.js").Dimension} Dimension
 * @typedef {import("../store.js").Store} Store
 */

const FIRST = 200;

/** @type {readonly {id: string, title: string}[]} */
const FILTERS = [
  { id: "all", title: "All" },
  { id: "constraints", title: "Constraints" },
  { id: "dimensions", title: "Dimensions" },
  { id: "selected", title: "Of the selection" },
  { id: "problems", title: "Problems" },
  { id: "off", title: "Switched off" },
];

/**
 * Constraints and dimensions that a search and a filter leave.
 * @param {Store} store
 * @param {string} search  words, all of which are to be found in name, kind or operands
 * @param {string} filter
 * @returns {(Constraint|Dimension)[]}
 */
export function found(store, search, filter) {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const selected = new Set([...store.selection].flatMap((name) => [name, name.split(".")[0]]));
  const { constraints } = store.verdict;
  /** @param {Constraint|Dimension} one */
  const fits = (one) => {
    if (filter === "selected" && !selected.has(one.name)) {
      if (!one.args.some((arg) => selected.has(arg) || selected.has(arg.split(".")[0]))) return false;
    }
    if (filter === "off" && one.active !== false) return false;
    if (filter === "problems") {
      const broken = "broken" in one && one.broken;
      if (!broken && !(one.name in constraints)) return false;
    }
    const text = `${one.name} ${one.kind} ${one.args.join(" ")}`.toLowerCase();
    return words.every((word) => text.includes(word));
  };
  const all = [
    ...(filter === "dimensions" ? [] : store.constraints.values()),
    ...(filter === "constraints" ? [] : store.dimensions.values()),
  ];
  return all.filter(fits);
}

/** @param {App} app @param {HTMLElement} element */
export function mount(app, element) {
  const { store } = app;
  let most = FIRST;
  const search = h("input", {
    type: "search",
    class: "search",
    placeholder: "Search",
    title: "words of name, kind and operands: parallel, L3, d0",
    "aria-label": "search constraints and dimensions",
    autocomplete: "off",
    spellcheck: "false",
  });
  const filter = h(
    "select",
    { class: "filter", "aria-label": "filter" },
    ...FILTERS.map(({ id, title }) => h("option", { value: id }, title)),
  );
  const count = h("p", { class: "count", "aria-live": "polite" });
  const rows = h("ul", { class: "rows" });
  const more = h("button", { class: "button more", hidden: true }, "Show more");
  fill(element, h("div", { class: "search-row" }, search, filter), count, rows, more);

  function show() {
    if (!app.panels?.isOpen("relations")) return;
    const all = found(store, search.value, filter.value);
    const total = store.constraints.size + store.dimensions.size;
    count.textContent = total ? `${all.length} of ${total}` : "No constraints or dimensions yet.";
    const focus = focusedRow(rows);
    fill(rows, ...all.slice(0, most).map((one) => row(app, one)));
    more.hidden = all.length <= most;
    if (focus) /** @type {HTMLElement|null} */ (rows.querySelector(`[data-name="${focus.name}"] ${focus.button}`))?.focus();
  }
  const soon = once(show);
  const anew = () => {
    most = FIRST;
    show();
  };
  search.addEventListener("input", anew);
  filter.addEventListener("change", anew);
  more.addEventListener("click", () => {
    most *= 4;
    show();
  });
  for (const type of ["change", "verdict", "selection"]) store.addEventListener(type, soon);
  return { show };
}

/** Where the focus is, to put it back after the rows are made anew. @param {HTMLElement} rows */
function focusedRow(rows) {
  const focused = rows.ownerDocument.activeElement;
  const name = focused instanceof HTMLElement ? focused.closest("[data-name]")?.getAttribute("data-name") : "";
  if (!name || !rows.contains(focused)) return null;
  const role = /** @type {HTMLElement} */ (focused).dataset.role ?? "pick";
  return { name, button: `[data-role="${role}"]` };
}

/** @type {Readonly<Record<string, string>>} */
const STATES = {
  redundant: "redundant: it follows from others",
  impossible: "impossible together with others",
  here: "redundant in this position only",
};

/** @param {App} app @param {Constraint|Dimension} one */
function row(app, one) {
  const { store } = app;
  const dimension = store.dimensions.has(one.name) ? /** @type {Dimension} */ (one) : null;
  const state = store.verdict.constraints[one.name] ?? "";
  const on = one.active !== false;
  const broken = dimension?.broken ?? "";
  const pick = h(
    "button",
    {
      class: "pick",
      "data-role": "pick",
      title: `${one.name}: ${one.kind} ${one.args.join(" ")}`,
      onclick: (/** @type {MouseEvent} */ event) => store.select([one.name], event.shiftKey ? "toggle" : "replace"),
    },
    icon(one.kind),
    h("span", { class: "row-name" }, one.name),
    h("span", { class: "row-text" }, `${one.kind.replaceAll("_", " ")} `, h("span", { class: "args" }, one.args.join(" "))),
  );
  const label = on ? `switch off ${one.name}` : `switch on ${one.name}`;
  const turn = button(on ? "switch_off" : "switch_on", label, "turn", () => app.run(`${on ? "switch_off" : "switch_on"} ${one.name}`));
  turn.setAttribute("aria-pressed", String(on));
  const remove = button("delete", `delete ${one.name}`, "delete", () => app.run(`delete ${one.name}`));
  const classes = ["row", "relation", on ? "" : "is-off", state, store.selection.has(one.name) ? "is-selected" : ""];
  return points(
    h(
      "li",
      { class: classes.filter(Boolean).join(" "), "data-name": one.name },
      pick,
      dimension ? value(app, dimension) : null,
      turn,
      remove,
      state || broken ? h("p", { class: "row-state" }, icon("warning"), broken || (STATES[state] ?? state)) : null,
    ),
    store,
    () => [one.name],
  );
}

/** @param {App} app @param {Dimension} one */
function value(app, one) {
  const { lengths } = app.store;
  const text = lengths.amount(one);
  const number = one.value ? lengths.text(one.value.number, quantityOf(one.kind)) : "";
  const words = one.derived ? `(${number})` : text;
  return h(
    "button",
    {
      class: "value",
      "data-role": "value",
      title: one.derived ? "driven (reference)" : `edit: ${text}${number && text !== number ? ` = ${number}` : ""}`,
      "aria-label": `value of ${one.name}: ${words}`,
      onclick: () => app.typing?.edit?.(one.name),
    },
    words,
  );
}

/** @param {string} name @param {string} label @param {string} role @param {() => unknown} act */
function button(name, label, role, act) {
  const props = { type: "button", class: "icon-button quiet", "aria-label": label, title: label, "data-role": role };
  return h("button", { ...props, onclick: act }, icon(name));
}
