/** What was refused, as elements: the message, its place in the text, a fix that can be clicked. */

import { h } from "./dom.js";
import { mentioning, points } from "./mention.js";

/**
 * @typedef {import("./app.js").App} App
 * @typedef {import("./types.js").Reply} Reply
 */

const COMMAND = /`([^`]+)`/g;
/** Commands of a hint that are offered as buttons: they take something out. */
const OFFERED = /^(delete|unlock|switch_off) /;

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
 * @returns {HTMLElement}
 */
export function failure(app, reply, text = "", again = text) {
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
  const buttons = offers(hint).map((command) => offer(app, command, next));
  if (buttons.length) found.append(h("div", { class: "offers" }, ...buttons));
  return points(found, app.store, () => error.names ?? []);
}

/**
 * A button that runs what a hint proposes, then repeats what was refused.
 * @param {App} app
 * @param {string} command
 * @param {string} again
 */
function offer(app, command, again) {
  const text = again ? `${command}; ${again}` : command;
  const names = command.split(" ").slice(1);
  const run = async (/** @type {Event} */ event) => {
    const note = /** @type {HTMLElement} */ (event.target).closest(".note");
    const reply = await app.run(text, { step: again || command });
    if (reply.ok) note?.remove();
  };
  return points(
    h("button", { class: "button", title: text, onclick: run }, again ? `${command} and repeat` : command),
    app.store,
    () => names,
  );
}
