/** Parameters: add, edit, rename, delete; what is refused is shown below its row. */

import { shown } from "../amounts.js";
import { fill, h, once } from "../dom.js";
import { failure } from "../failure.js";
import { icon } from "../icons.js";
import { argument, linked } from "../tools/compose.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../types.js").Parameter} Parameter
 */

/** @param {App} app @param {HTMLElement} element */
export function mount(app, element) {
  const { store } = app;
  const rows = h("div", { class: "rows", role: "list" });
  const empty = h("p", { class: "empty" }, "No parameters yet. Dimensions can read them by name: width, width / 2.");
  const name = input("name of the new parameter", "width");
  const value = input("value of the new parameter", "10");
  const problem = h("div", { class: "row-problem", role: "alert" });
  const form = h(
    "form",
    { class: "param-new" },
    name,
    h("span", { class: "equals", "aria-hidden": "true" }, "="),
    value,
    h("button", { type: "submit", class: "icon-button", "aria-label": "add the parameter", title: "Add" }, icon("add")),
  );
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const reply = await app.wire.run(`param ${argument(name.value.trim())} ${argument(linked(value.value))}`);
    fill(problem, reply.ok ? null : failure(app, reply));
    if (!reply.ok) return;
    name.value = value.value = "";
    name.focus();
  });
  fill(element, empty, rows, form, problem);

  function show() {
    if (!app.panels?.isOpen("parameters")) return;
    const focused = element.ownerDocument.activeElement;
    // a row that is being written in is not taken away
    if (focused && rows.contains(focused) && focused instanceof HTMLInputElement) return;
    empty.hidden = store.parameters.size > 0;
    fill(rows, ...[...store.parameters.values()].map((one) => row(app, one, show)));
  }
  store.addEventListener("change", once(show));
  return { show };
}

/** @param {string} label @param {string} placeholder */
function input(label, placeholder) {
  return h("input", {
    type: "text",
    class: "cell",
    "aria-label": label,
    placeholder,
    autocomplete: "off",
    autocapitalize: "off",
    spellcheck: "false",
  });
}

/** @param {App} app @param {Parameter} one @param {() => void} again */
function row(app, one, again) {
  const name = input(`name of ${one.name}`, "");
  const text = input(`value of ${one.name}`, "");
  name.value = one.name;
  text.value = one.amount.text;
  name.classList.add("param-name");
  const number = shown(one.amount.number);
  const problem = h("div", { class: "row-problem", role: "alert" }, one.broken || null);
  const remove = h(
    "button",
    {
      class: "icon-button quiet",
      "aria-label": `delete ${one.name}`,
      title: "Delete",
      onclick: () => run(`del_param ${one.name}`),
    },
    icon("delete"),
  );
  /** @param {string} command @param {HTMLInputElement} [field] */
  async function run(command, field) {
    const reply = await app.wire.run(command);
    fill(problem, reply.ok ? null : failure(app, reply, command, ""));
    field?.toggleAttribute("aria-invalid", !reply.ok);
    if (reply.ok && field) field.blur();
    if (reply.ok) again();
  }
  /** @param {HTMLInputElement} field @param {string} before @param {(now: string) => string} command */
  function edits(field, before, command) {
    const commit = () => {
      const now = field.value.trim();
      if (now && now !== before) run(command(now), field);
      else field.value = before;
    };
    field.addEventListener("change", commit);
    field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") field.blur();
      if (event.key !== "Escape") return;
      field.value = before;
      fill(problem);
      field.blur();
      event.stopPropagation();
    });
  }
  edits(name, one.name, (now) => `rename_param ${one.name} ${argument(now)}`);
  edits(text, one.amount.text, (now) => `param ${one.name} ${argument(linked(now))}`);
  return h(
    "div",
    { class: "row param", role: "listitem" },
    name,
    h("span", { class: "equals", "aria-hidden": "true" }, "="),
    text,
    h("output", { class: "number", title: number }, one.amount.text === number ? "" : number),
    remove,
    problem,
  );
}
