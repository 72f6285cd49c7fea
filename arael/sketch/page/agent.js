/** Agents that want to change something: allow, refuse, always; and the permissions that stand. */

import { fill, h } from "./dom.js";

/** @typedef {{id: string, agent: string, what: string, tool: string}} Request */

/** @param {import("./app.js").App} app */
export function askForAgents(app) {
  app.store.addEventListener("status", (event) => {
    const message = /** @type {CustomEvent} */ (event).detail;
    if (message.type === "agent") ask(app, message);
    if (message.type === "agent_answered") app.notes?.close(`agent-${message.id}`);
  });
}

/**
 * The part of the status bar that lists standing permissions, each with a button that takes it back.
 * @param {import("./app.js").App} app
 */
export function permissionsBar(app) {
  const element = h("span", { class: "status-agents", role: "status", "aria-label": "agents that may draw" });
  app.store.addEventListener("status", (event) => {
    const message = /** @type {CustomEvent} */ (event).detail;
    if (message.type !== "permissions") return;
    const agents = /** @type {{session: string, name: string}[]} */ (message.agents);
    fill(
      element,
      ...agents.map(({ session, name }) => {
        const revoke = () => app.wire.revoke(session);
        const label = `revoke the permission of ${name}`;
        return h("span", {}, `${name} may draw `, h("button", { class: "button", "aria-label": label, onclick: revoke }, "Revoke"));
      }),
    );
  });
  return element;
}

/** @param {import("./app.js").App} app @param {Request} message */
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
    text: `${message.agent} wants to change the sketch (${message.tool})`,
    key,
    stays: true,
    more: [h("pre", { class: "what" }, message.what), buttons],
  });
  note?.querySelector(".close")?.addEventListener("click", () => answer(false));
}
