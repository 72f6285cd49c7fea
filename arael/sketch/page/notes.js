/** Messages over the drawing: short-lived notes, errors that stay, questions, what is under way. */

import { h } from "./dom.js";
import { failure } from "./failure.js";
import { icon } from "./icons.js";
import { mentioning } from "./mention.js";

/**
 * @typedef {"info"|"warning"|"error"} Level
 *
 * @typedef {object} Note
 * @property {Level} level
 * @property {string} text
 * @property {string} [hint]
 * @property {string} [key]  a later note of the same key takes its place
 * @property {boolean} [stays]  until it is closed; errors always stay
 * @property {Node[]} [more]
 */

const SHOWN = 5000;
const MOST = 4;

/** The stack of messages. */
export class Notes {
  /** @param {import("./app.js").App} app @param {HTMLElement} stage */
  constructor(app, stage) {
    this.app = app;
    this.element = h("div", { class: "notes", role: "log", "aria-live": "polite", "aria-label": "messages" });
    stage.append(this.element);
    app.addEventListener("refused", (event) => {
      const { text, reply } = /** @type {CustomEvent} */ (event).detail;
      this.refused(reply, text);
    });
    // what was refused is not what the drawing shows any more
    app.wire.addEventListener("ran", () => this.close("refused"));
    app.addEventListener("ran", (event) => {
      const { reply } = /** @type {CustomEvent} */ (event).detail;
      if (reply.notes?.length) this.show({ level: "info", text: reply.notes.join("\n"), key: "notes" });
    });
    app.store.addEventListener("message", (event) => this.show(/** @type {CustomEvent} */ (event).detail));
  }

  /**
   * Show a message.
   * @param {Note} note
   * @returns {HTMLElement}
   */
  show(note) {
    const body = h("p", {}, ...mentioning(this.app.store, note.text));
    const hint = note.hint ? h("p", { class: "hint" }, ...mentioning(this.app.store, note.hint)) : null;
    return this._add(note.level, note.key, note.stays || note.level === "error", [body, hint, ...(note.more ?? [])]);
  }

  /**
   * Show why a command was refused.
   * @param {import("./types.js").Reply} reply
   * @param {string} text
   */
  refused(reply, text) {
    return this._add("error", "refused", true, [failure(this.app, reply, text)]);
  }

  /** Close the note of a key. @param {string} key */
  close(key) {
    this.element.querySelector(`[data-key="${key}"]`)?.remove();
  }

  /**
   * @param {Level} level
   * @param {string|undefined} key
   * @param {boolean} stays
   * @param {(Node|null)[]} content
   */
  _add(level, key, stays, content) {
    if (key) this.close(key);
    const close = h(
      "button",
      { class: "close", "aria-label": "close the message", onclick: () => this._remove(note) },
      icon("close"),
    );
    const role = level === "error" ? "alert" : "status";
    const note = h(
      "div",
      { class: `note ${level}`, role, "data-key": key },
      icon(level),
      h("div", { class: "note-body" }, ...content),
      close,
    );
    this.element.append(note);
    while (this.element.children.length > MOST) this.element.firstElementChild?.remove();
    if (!stays) this._expire(note);
    return note;
  }

  /** A note under the pointer or with the focus stays. @param {HTMLElement} note */
  _expire(note) {
    setTimeout(() => {
      if (note.matches(":hover, :focus-within")) this._expire(note);
      else this._remove(note);
    }, SHOWN);
  }

  /** @param {HTMLElement} note */
  _remove(note) {
    const focused = note.contains(note.ownerDocument.activeElement);
    note.remove();
    this.app.store.hover([]);
    if (focused) this.app.canvas.focus();
  }
}
