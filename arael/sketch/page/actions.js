/** The table of all actions: keys, menus, buttons, help and the documents' table of keys come from it. */

import { CONSTRAINTS } from "./actions/constraints.js";
import { DIMENSIONS } from "./actions/dimensions.js";
import { EDITING } from "./actions/editing.js";
import { FILING } from "./actions/filing.js";
import { TOOL_KEYS } from "./actions/tools.js";
import { VIEWING } from "./actions/viewing.js";
import { picked } from "./picked.js";

/**
 * @typedef {import("./app.js").App} App
 *
 * @typedef {object} Action
 * @property {string} id
 * @property {string} title
 * @property {string} key  "" if it has none
 * @property {string[]} [also]  further keys
 * @property {string} group  one of GROUPS
 * @property {string} [needs]  what has to be selected, in words
 * @property {(app: App) => boolean} [enabled]  true if it is left out
 * @property {boolean} [collects]  things are picked for it where the selection does not fit
 * @property {number} [most]  how many it takes, 2 if left out
 * @property {boolean} [chain]  any number, until Enter
 * @property {(app: App) => boolean} [checked]  of actions that switch
 * @property {(app: App) => unknown} run
 */

/** Groups in the order of the help. @type {Readonly<Record<string, string>>} */
export const GROUPS = {
  tool: "Tools",
  constrain: "Constraints",
  dimension: "Dimensions",
  edit: "Edit",
  view: "View",
  panels: "Panels",
  file: "Files",
  help: "Help",
};

/**
 * @param {readonly import("./types.js").ToolSpec[]} tools
 * @returns {Action[]}
 */
function toolActions(tools) {
  return tools.map(({ id, title, key }) => ({
    id: `tool_${id}`,
    title,
    key: TOOL_KEYS[id] ?? key,
    group: "tool",
    checked: (app) => app.tools.id === id,
    run: (app) => app.tools.start(id),
  }));
}

/** @returns {Action[]} */
function constraintActions() {
  return CONSTRAINTS.map((one) => ({
    id: one.id,
    title: one.title,
    key: one.key,
    needs: one.needs,
    group: "constrain",
    collects: true,
    most: one.most,
    enabled: (app) => one.command(picked(app.store)) !== "",
    run: (app) => app.run(one.command(picked(app.store))),
  }));
}

/** @returns {Action[]} */
function dimensionActions() {
  return DIMENSIONS.map((one) => ({
    id: one.id,
    title: one.title,
    key: one.key,
    needs: one.needs,
    group: "dimension",
    collects: true,
    chain: one.chain,
    enabled: (app) => one.operands(picked(app.store)).length > 0,
    run: (app) => app.typing?.add?.(one, one.operands(picked(app.store))),
  }));
}

/**
 * All actions.
 * @param {readonly import("./types.js").ToolSpec[]} tools
 * @returns {Action[]}
 */
export function allActions(tools) {
  return [
    ...toolActions(tools),
    ...constraintActions(),
    ...dimensionActions(),
    ...EDITING,
    ...VIEWING,
    ...FILING,
  ];
}

/** The actions of an application. */
export class Actions {
  /** @type {Map<string, Action>} */
  byKey = new Map();

  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.list = allActions(app.tools.table);
    this.byId = new Map(this.list.map((one) => [one.id, one]));
    for (const one of this.list) {
      for (const key of [one.key, ...(one.also ?? [])]) if (key) this.byKey.set(key, one);
    }
  }

  /** @param {string} id @returns {Action} */
  get(id) {
    const found = this.byId.get(id);
    if (!found) throw new Error(`no action ${id}`);
    return found;
  }

  /** @param {Action} one */
  isEnabled(one) {
    return one.enabled?.(this.app) ?? true;
  }

  /**
   * Run an action; where the selection does not fit pick what it needs, or report that.
   * @param {string} id
   */
  run(id) {
    const one = this.get(id);
    if (this.isEnabled(one)) return one.run(this.app);
    if (one.collects) return this.app.tools.collect(one);
    this.refuse(one);
    return undefined;
  }

  /** Report what an action needs. @param {Action} one */
  refuse(one) {
    const needs = one.needs ? `${one.title} needs ${one.needs}` : `${one.title}: nothing to do`;
    const hint = one.needs && !one.collects ? "select with Shift for several, then repeat it" : "";
    this.app.notes?.show({ level: "info", text: needs, hint, key: "needs" });
  }
}

/**
 * A tooltip: title and key.
 * @param {Action} one
 */
export function tooltip(one) {
  const key = one.key ? ` (${one.key})` : "";
  return `${one.title}${key}${one.needs ? `: ${one.needs}` : ""}`;
}
