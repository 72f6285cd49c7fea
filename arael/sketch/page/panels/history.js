/** The steps of the sketch: a click goes there. */

import { fill, h, once, roving } from "../dom.js";

/** @typedef {import("../app.js").App} App */

/**
 * Steps as they are listed, and the command that goes to each.
 * @param {{done: string[], undone: string[]}} history  `undone`: the next one first
 * @returns {{title: string, command: string, state: "done"|"now"|"undone"}[]}
 */
export function steps({ done, undone }) {
  const last = done.length - 1;
  return [
    ...done.map((title, i) => ({
      title,
      command: i === last ? "" : `undo ${last - i}`,
      state: /** @type {"now"|"done"} */ (i === last ? "now" : "done"),
    })),
    ...undone.map((title, i) => ({ title, command: `redo ${i + 1}`, state: /** @type {"undone"} */ ("undone") })),
  ];
}

/**
 * A step as a person reads it: without the words by which a tool adds its constraints itself.
 * @param {string} title
 */
export const readable = (title) => title.replace(/ (noconnect|notangent|nocursor)\b/g, "");

/** @param {App} app @param {HTMLElement} element */
export function mount(app, element) {
  const { store } = app;
  const list = h("ol", { class: "steps" });
  const empty = h("p", { class: "empty" }, "No steps yet.");
  fill(element, empty, list);
  roving(list, ".step");

  function show() {
    if (!app.panels?.isOpen("history")) return;
    const all = steps(store.history);
    empty.hidden = all.length > 0;
    const start = h("li", {}, step("Start", store.history.done.length ? `undo ${store.history.done.length}` : "", store.history.done.length ? "done" : "now"));
    fill(list, all.length ? start : null, ...all.map((one) => h("li", {}, step(one.title, one.command, one.state))));
    list.querySelector(".now")?.scrollIntoView({ block: "nearest" });
  }

  /** @param {string} title @param {string} command @param {string} state */
  function step(title, command, state) {
    return h(
      "button",
      {
        class: `step ${state}`,
        title,
        "aria-current": state === "now" ? "step" : null,
        onclick: () => command && app.run(command),
      },
      readable(title),
    );
  }
  store.addEventListener("history", once(show));
  return { show };
}
