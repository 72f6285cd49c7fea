/** Help over the page: keys and tools with a search, and the manual of the commands. */

import { GROUPS } from "./actions.js";
import { WORDS } from "./actions/words.js";
import { fill, h } from "./dom.js";
import { icon } from "./icons.js";
import { keyName } from "./keys.js";

/**
 * @typedef {import("./app.js").App} App
 * @typedef {{name: string, group: string, usage: string[], summary: string, details: string, aliases: string[]}} Command
 */

/** What the pointer does, for the help and the documents. */
export const POINTER = [
  { key: "Click", title: "Pick, or set a point; with Shift add to the selection" },
  { key: "Drag", title: "Move points, curves, dimension texts; from an empty place select by a box" },
  { key: "Drag with the middle button", title: "Pan; with two fingers on a touch screen" },
  { key: "Wheel", title: "Zoom at the pointer; pinch on a touch screen" },
  { key: "Double click", title: "Select a chain; edit a dimension" },
  { key: "Right click", title: "Finish what is drawn; else a menu of what fits what is there" },
  { key: "Ctrl, or B", title: "No automatic constraints while it is held; B where no value can be typed" },
];

/**
 * Whether an action is found by what is typed: by its title, its key, or a word of other programs.
 * @param {import("./actions.js").Action} one @param {string} word  in lower case
 */
export function isFound(one, word) {
  return `${one.title} ${one.key} ${one.id} ${WORDS[one.id] ?? ""}`.toLowerCase().includes(word);
}

/** Keys of the drawing itself, for the help and the documents. */
export const DRAWING = [
  { key: "Arrow keys", title: "Move the drawing cursor by a grid step (Shift: 50 pixels, Alt: 1 pixel)" },
  { key: "Enter", title: "Click at the cursor; enter a typed value" },
  { key: "0-9, A-Z", title: "Type a length or an angle while drawing: a number, or an expression whose names complete" },
  { key: "Tab", title: "Next value while drawing; next of several things below the cursor" },
  { key: "Escape", title: "Drop what was begun, then the tool, then the selection" },
];

export class Help {
  /** @type {HTMLDialogElement|null} */
  dialog = null;

  /** @param {App} app */
  constructor(app) {
    this.app = app;
  }

  /** @param {"keys"|"manual"} page */
  open(page) {
    this.dialog?.close();
    const body = h("div", { class: "help-body", tabindex: -1 });
    const search = h("input", { type: "search", class: "search", placeholder: page === "keys" ? "Find an action or key" : "Find a command", "aria-label": "search the help" });
    const tabs = /** @type {const} */ (["keys", "manual"]).map((id) =>
      h(
        "button",
        { class: "help-tab", "aria-pressed": String(id === page), onclick: () => this.open(id) },
        id === "keys" ? "Keys and tools" : "Commands",
      ),
    );
    const dialog = h("dialog", { class: "dialog help", "aria-label": "help" });
    const close = h("button", { class: "close", "aria-label": "close the help", onclick: () => dialog.close() }, icon("close"));
    fill(dialog, h("div", { class: "help-head" }, ...tabs, search, close), body);
    dialog.addEventListener("close", () => dialog.remove());
    dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
    // A search with text would keep Escape for itself; the key that opens the help also closes it.
    dialog.addEventListener("keydown", (event) => {
      if (!/^(Escape|Ctrl\+K)$/.test(keyName(event))) return;
      event.preventDefault();
      dialog.close();
      this.app.canvas.focus();
    });
    this.dialog = dialog;
    this.app.root.append(dialog);
    dialog.showModal();
    search.focus();
    const show = page === "keys" ? () => this._keys(body, search.value) : () => this._manual(body, search.value);
    search.addEventListener("input", show);
    search.addEventListener("keydown", (event) => {
      if (event.key === "Enter") /** @type {HTMLElement|null} */ (body.querySelector("button"))?.click();
    });
    show();
  }

  /** @param {HTMLElement} body @param {string} search */
  _keys(body, search) {
    const { app } = this;
    const word = search.trim().toLowerCase();
    const parts = Object.entries(GROUPS).map(([group, title]) => {
      const rows = app.actions.list
        .filter((one) => one.group === group && isFound(one, word))
        .map((one) => this._action(one));
      return rows.length ? h("section", {}, h("h3", {}, title), ...rows) : null;
    });
    const pointer = [...POINTER, ...DRAWING]
      .filter(({ key, title }) => `${key} ${title}`.toLowerCase().includes(word))
      .map(({ key, title }) => h("div", { class: "help-row" }, h("span", {}, title), h("kbd", {}, key)));
    fill(body, h("div", { class: "help-columns" }, ...parts, pointer.length ? h("section", {}, h("h3", {}, "Drawing"), ...pointer) : null));
    if (!body.querySelector(".help-row")) fill(body, h("p", { class: "empty" }, `Nothing found for ${search}`));
  }

  /** @param {import("./actions.js").Action} one */
  _action(one) {
    const run = () => {
      this.dialog?.close();
      this.app.canvas.focus();
      this.app.actions.run(one.id);
    };
    return h(
      "button",
      { class: "help-row", onclick: run, title: one.needs ? `needs ${one.needs}` : null },
      icon(one.id),
      h("span", {}, one.title),
      one.key ? h("kbd", {}, one.key) : null,
    );
  }

  /** @param {HTMLElement} body @param {string} search */
  async _manual(body, search) {
    const reply = await this.app.wire.ask("table");
    const data = /** @type {{groups: Record<string, string>, commands: Command[]}|undefined} */ (reply.data);
    if (!reply.ok || !data) {
      fill(body, h("p", { class: "empty" }, reply.text));
      return;
    }
    const word = search.trim().toLowerCase();
    const fits = (/** @type {Command} */ one) =>
      `${one.name} ${one.aliases.join(" ")} ${one.summary}`.toLowerCase().includes(word);
    const parts = Object.entries(data.groups).map(([group, title]) => {
      const rows = data.commands.filter((one) => one.group === group && fits(one)).map((one) => this._command(one));
      return rows.length ? h("section", {}, h("h3", {}, title), ...rows) : null;
    });
    fill(body, ...parts);
    if (!body.querySelector("details")) fill(body, h("p", { class: "empty" }, `Nothing found for ${search}`));
  }

  /** @param {Command} one */
  _command(one) {
    const details = one.details.trim().split(/\n{2,}/).filter(Boolean);
    const write = () => {
      this.dialog?.close();
      this.app.field?.open(`${one.name} `);
    };
    return h(
      "details",
      { class: "help-command" },
      h("summary", {}, h("code", {}, one.name), h("span", {}, one.summary)),
      h("pre", {}, one.usage.join("\n")),
      ...details.map((text) =>
        text.startsWith("```") ? h("pre", {}, text.replaceAll(/```\n?/g, "").trim()) : h("p", {}, text.replaceAll("`", "").replaceAll("\n", " ")),
      ),
      one.aliases.length ? h("p", { class: "hint" }, `Also: ${one.aliases.join(", ")}`) : null,
      h("button", { class: "button", onclick: write }, "Write it in the command field"),
    );
  }
}
