/** What is selected: its facts, what holds it, and how two things lie to each other. */

import { fill, h, later, put } from "../dom.js";
import { mentioning } from "../mention.js";
import { picked } from "../picked.js";
import { actionButton } from "../buttons.js";
import { renamable, rename } from "./renaming.js";

/** @typedef {import("../app.js").App} App */

const MOST = 60;
const ACTIONS = ["rename", "construction", "quiet", "style_solid", "style_dashed", "style_dashdot", "lock", "unlock", "delete"];
const RELATION_ACTIONS = ["edit_value", "rename", "set_derived", "set_driven", "switch_off", "switch_on", "delete"];

/** @param {App} app @param {HTMLElement} element */
export function mount(app, element) {
  const { store } = app;
  const names = h("div", {
    class: "chips",
    ondblclick: (/** @type {MouseEvent} */ { target }) => target instanceof HTMLInputElement || edit(),
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "F2" || event.shiftKey || event.target instanceof HTMLInputElement) return;
      event.preventDefault();
      edit();
    },
  });
  /** Names that are shown: they stay while they are the same, so that a double click has one target. */
  let written = "";
  const actions = h("div", { class: "row-actions" });
  const facts = h("div", { class: "facts", "aria-live": "polite" });
  const empty = h(
    "p",
    { class: "empty" },
    "Nothing is selected. Click in the drawing, with Shift for several; drag a box for many.",
  );
  fill(element, empty, names, actions, facts);
  let asked = 0;

  function edit() {
    const name = renamable(store);
    if (!name) return;
    rename(app, names, name, () => {
      written = "";
      show();
      app.canvas.focus();
    });
  }

  async function ask() {
    if (!app.panels?.isOpen("selection")) return;
    const mine = ++asked;
    const all = [...store.selection];
    const found = all.length === 1 ? await one(app, all[0]) : all.length === 2 ? await two(app, all) : [];
    if (mine === asked) fill(facts, ...found);
  }
  const soon = later(120, ask);

  function show() {
    if (!app.panels?.isOpen("selection")) return;
    const all = [...store.selection];
    empty.hidden = all.length > 0;
    const text = all.join(" ");
    if (text !== written) {
      fill(names, ...mentioning(store, all.slice(0, MOST).join(" ")));
      if (all.length > MOST) put(names, [`and ${all.length - MOST} more`]);
      written = text;
    }
    const relation = picked(store).relations.length > 0;
    const ids = (relation ? RELATION_ACTIONS : ACTIONS).filter((id) => app.actions.isEnabled(app.actions.get(id)));
    fill(actions, ...(all.length ? ids.map((id) => actionButton(app, id)) : []));
    if (!all.length) fill(facts);
    soon();
  }

  for (const type of ["selection", "change"]) store.addEventListener(type, show);
  app.addEventListener("rename", edit);
  return { show };
}

/** @param {App} app @param {string} name */
async function one(app, name) {
  const entity = app.store.offset(name) >= 0 || app.store.entities.has(name);
  const [info, why] = await Promise.all([
    app.wire.ask("info", { name }),
    entity ? app.wire.ask("why", { name }) : null,
  ]);
  const facts = why ? withoutRelations(app, info.text) : info.text;
  return [section(app, "Facts", facts), why ? section(app, "Held by", held(why.text)) : null];
}

/** @param {App} app @param {string[]} names */
async function two(app, names) {
  const { store, wire } = app;
  if (!names.every((name) => store.entities.has(name) || store.point(name))) return [];
  const reply = await wire.ask("measure", { names: names.join(" ") });
  return reply.ok ? [section(app, "Measured", reply.text)] : [];
}

/** Lines that are no constraints and dimensions: those are listed below. @param {App} app @param {string} text */
function withoutRelations(app, text) {
  const { constraints, dimensions } = app.store;
  const named = (/** @type {string} */ line) => line.trim().split(":")[0];
  return text
    .split("\n")
    .filter((line) => !constraints.has(named(line)) && !dimensions.has(named(line)))
    .join("\n");
}

/** The lines of an answer of `why` without their head. @param {string} text */
function held(text) {
  const lines = text.split("\n").slice(1);
  return lines.length ? lines.join("\n") : "nothing";
}

/** @param {App} app @param {string} title @param {string} text */
function section(app, title, text) {
  const lines = text.split("\n").map((line) => h("li", {}, ...mentioning(app.store, line.trim())));
  return h("div", { class: "facts-part" }, h("h3", {}, title), h("ul", { class: "lines" }, ...lines));
}
