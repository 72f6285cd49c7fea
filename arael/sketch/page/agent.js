/** The question of an agent that wants to change something: allow, refuse, always. */

import { h } from "./dom.js";

/** @param {import("./app.js").App} app */
export function askForAgents(app) {
  app.store.addEventListener("status", (event) => {
    const message = /** @type {CustomEvent} */ (event).detail;
    if (message.type === "agent") ask(app, message);
    if (message.type === "agent_answered") app.notes?.close(`agent-${message.id}`);
  });
}

/** @param {import("./app.js").App} app @param {{id: number|string, what: string, tool: string}} message */
function ask(app, message) {
  const key = `agent-${message.id}`;
  /** @param {boolean} allow @param {boolean} [always] */
  const answer = (allow, always = false) => {
    app.wire.answer(message.id, allow, always);
    app.notes?.close(key);
    app.canvas.focus();
  };
  const buttons = h(
    "div",
    { class: "offers" },
    h("button", { class: "button primary", onclick: () => answer(true) }, "Allow"),
    h("button", { class: "button", onclick: () => answer(false) }, "Refuse"),
    h("button", { class: "button", onclick: () => answer(true, true) }, "Always allow"),
  );
  const note = app.notes?.show({
    level: "warning",
    text: `An agent wants to change the sketch (${message.tool})`,
    key,
    stays: true,
    more: [h("pre", { class: "what" }, message.what), buttons],
  });
  note?.querySelector(".close")?.addEventListener("click", () => answer(false));
}
