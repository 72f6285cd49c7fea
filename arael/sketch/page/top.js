/** The bar at the top: menus, undo and redo with the names of the steps, file, freedoms, theme. */

import { actionButton, refresh } from "./buttons.js";
import { fill, h, once } from "./dom.js";
import { icon } from "./icons.js";
import { mountMenus } from "./menu.js";
import { readable } from "./panels/history.js";
import { mountStrip } from "./strip.js";

/** @param {import("./app.js").App} app @param {HTMLElement} element */
export function mountTop(app, element) {
  const { store } = app;
  const menus = h("div", { class: "menus" });
  const undo = actionButton(app, "undo");
  const redo = actionButton(app, "redo");
  const name = h("span", { class: "file-name" });
  const readOnly = h("span", { class: "read-only", role: "status", hidden: true }, icon("warning"), "read-only");
  const saved = h("span", { class: "saved", role: "status" });
  const freedoms = h("button", { class: "freedoms-button", onclick: () => app.panels?.toggle("freedom") });
  const strip = h("div", { class: "strip" });
  fill(
    element,
    h(
      "div",
      { class: "bar" },
      menus,
      h("span", { class: "divider", role: "presentation" }),
      undo,
      redo,
      h("div", { class: "file" }, name, readOnly, saved),
      freedoms,
      actionButton(app, "fit"),
      actionButton(app, "theme"),
      actionButton(app, "keys"),
    ),
    strip,
  );
  mountMenus(app, menus);
  mountStrip(app, strip);

  const steps = once(() => {
    const { done, undone } = store.history;
    const last = readable(done[done.length - 1] ?? "");
    const next = readable(undone[0] ?? "");
    undo.title = last ? `Undo: ${last} (Ctrl+Z)` : "Nothing to undo";
    redo.title = next ? `Redo: ${next} (Ctrl+Shift+Z)` : "Nothing to redo";
    undo.setAttribute("aria-label", last ? `Undo: ${last}` : "Undo");
    redo.setAttribute("aria-label", next ? `Redo: ${next}` : "Redo");
    refresh(app, element);
  });
  const judged = once(() => {
    const { text, state, title, sign } = summary(store);
    freedoms.dataset.state = state;
    freedoms.hidden = store.entities.size === 0;
    freedoms.title = title;
    const [count, word = ""] = text.split(/ (.*)/);
    freedoms.setAttribute("aria-label", text);
    fill(freedoms, icon(sign), h("span", {}, count, word ? h("span", { class: "word" }, ` ${word}`) : null));
  });
  store.addEventListener("history", steps);
  store.addEventListener("verdict", judged);
  store.addEventListener("change", judged);
  store.addEventListener("change", () => saved.replaceChildren());
  store.addEventListener("status", (event) => {
    const message = /** @type {CustomEvent} */ (event).detail;
    if (message.type === "hello") {
      fill(name, message.file || "not in a file");
      readOnly.hidden = !message.readonly;
      readOnly.title = `${message.readonly}: changes are not kept. The command "save other.json" writes a copy.`;
      app.root.ownerDocument.title = `${message.file || "sketch"} – arael`;
    }
    if (message.type === "saved") {
      fill(saved, icon("check"), "saved");
      if (message.file) fill(name, message.file);
    }
  });
  steps();
  judged();
}

/**
 * The verdict in two words. What is redundant is harmless, what is impossible is not.
 * @param {import("./store.js").Store} store
 */
export function summary(store) {
  if (!store.isJudged) {
    const text = store.unjudged === store.revision ? "not checked" : "checking ...";
    return { state: "unknown", sign: "panel_freedom", text, title: "What can still move is not known yet" };
  }
  const { freedoms, constraints } = store.verdict;
  const states = Object.values(constraints);
  const bad = states.filter((state) => state === "impossible").length;
  const redundant = states.filter((state) => state === "redundant").length;
  if (bad) {
    return { state: "bad", sign: "warning", text: `${bad} impossible`, title: "Constraints that contradict one another" };
  }
  if (redundant) {
    const title = "Constraints that follow from others: harmless, and listed in the panel";
    return { state: "redundant", sign: "warning", text: `${redundant} redundant`, title };
  }
  if (freedoms === 0 && store.entities.size) {
    return { state: "defined", sign: "defined", text: "Defined", title: "Nothing can move" };
  }
  const title = `${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom: what can still move`;
  return { state: "free", sign: "panel_freedom", text: `${freedoms} free`, title };
}
