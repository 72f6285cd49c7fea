/** What was refused, as elements: the message, its place in the text, a fix that can be clicked. */

import { h } from "./dom.js";
import { mentioning, points } from "./mention.js";

/**
 * @typedef {import("./app.js").App} App
 * @typedef {import("./types.js").Reply} Reply
 * @typedef {{command: string, title: string}} Reference  a dimension that only measures, in place of one that holds
 */

const COMMAND = /`([^`]+)`/g;
/** Commands of a hint that are offered as buttons: they take something out. */
const OFFERED = /^(delete|unlock|switch_off) /;

/** Refusals of a dimension that may be kept as a reference. */
const TOO_MANY = new Set(["E1230", "E1231", "E1233", "E1234"]);

/**
 * Commands that a hint proposes and that can be run as they are.
 * @param {string} hint
 * @returns {string[]}
 */
export function offers(hint) {
  return [...hint.matchAll(COMMAND)].map((match) => match[1]).filter((text) => OFFERED.test(text));
}

/**
 * A text with a place marked: before, marked, after.
 * @param {string} text
 * @param {number} from
 * @param {number} to
 * @returns {[string, string, string]}
 */
export function marked(text, from, to) {
  const start = Math.min(Math.max(from, 0), text.length);
  const end = Math.min(Math.max(to, start), text.length);
  return [text.slice(0, start), text.slice(start, end), text.slice(end)];
}

/**
 * Plain words of a message: backquotes are left out.
 * @param {string} text
 */
const plain = (text) => text.replaceAll("`", "");

/**
 * @param {App} app
 * @param {Reply} reply  that was refused
 * @param {string} [text]  what was run, to mark the place in
 * @param {string} [again]  what to run after something was taken out
 * @param {{reference?: Reference, done?: () => void}} [more]  what to offer first where a dimension is one too
 *   many; `done` is called when a button has succeeded
 * @returns {HTMLElement}
 */
export function failure(app, reply, text = "", again = text, { reference, done } = {}) {
  const error = reply.error ?? { code: "", message: reply.text };
  const hint = error.hint ?? "";
  const found = h("div", { class: "failure" });
  if (text && typeof error.from === "number" && typeof error.to === "number" && error.to - error.from < text.length) {
    const [before, wrong, after] = marked(text, error.from, error.to);
    found.append(h("code", { class: "line" }, before, h("mark", {}, wrong || " "), after));
  }
  found.append(
    h(
      "p",
      { class: "failure-text" },
      ...mentioning(app.store, plain(error.message)),
      error.code ? h("span", { class: "code" }, error.code) : null,
    ),
  );
  if (hint) found.append(h("p", { class: "hint" }, ...mentioning(app.store, plain(hint))));
  // What is there already is not repeated after it was taken out.
  const next = error.code === "E1221" ? "" : again;
  const buttons = offers(hint).map((command) => {
    const whole = next ? `${command}; ${next}` : command;
    return offer(app, whole, next ? `${command} and repeat` : command, { names: command.split(" ").slice(1), step: again || command, done });
  });
  if (reference && TOO_MANY.has(error.code)) buttons.unshift(offer(app, reference.command, reference.title, { names: [], step: reference.title, done }));
  if (buttons.length) found.append(h("div", { class: "offers" }, ...buttons));
  return points(found, app.store, () => error.names ?? []);
}

/**
 * A button that runs commands, in one step of undo.
 * @param {App} app
 * @param {string} text  the commands
 * @param {string} title
 * @param {{names: string[], step: string, done?: () => void}} more  what lights up in the drawing; the name of the step
 */
function offer(app, text, title, { names, step, done }) {
  const run = async (/** @type {Event} */ event) => {
    const note = /** @type {HTMLElement} */ (event.target).closest(".note");
    const reply = await app.run(text, { step });
    if (!reply.ok) return;
    note?.remove();
    done?.();
  };
  return points(h("button", { class: "button", type: "button", title: text, onclick: run }, title), app.store, () => names);
}
