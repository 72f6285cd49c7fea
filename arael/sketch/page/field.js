/** The command field: history, completion, usage, replies and errors with the place marked. */

import { Completion } from "./completion.js";
import { fill, h } from "./dom.js";
import { failure } from "./failure.js";
import { icon } from "./icons.js";
import { mentioning } from "./mention.js";
import { remember, remembered } from "./memory.js";

/** @typedef {import("./app.js").App} App */

const KEPT = 100;
const KEY = "commands";

/** Lines that were entered: going back keeps what was being written. */
export class Past {
  draft = "";

  /** @param {string[]} lines  oldest first */
  constructor(lines) {
    this.lines = lines.slice(-KEPT);
    this.at = this.lines.length;
  }

  /** @param {string} line */
  add(line) {
    if (this.lines[this.lines.length - 1] !== line) this.lines.push(line);
    if (this.lines.length > KEPT) this.lines.shift();
    this.at = this.lines.length;
    this.draft = "";
  }

  /**
   * The line before or after.
   * @param {-1|1} step
   * @param {string} now  what stands in the field
   * @returns {string|null} null if there is none
   */
  go(step, now) {
    const next = this.at + step;
    if (next < 0 || next > this.lines.length) return null;
    if (this.at === this.lines.length) this.draft = now;
    this.at = next;
    return next === this.lines.length ? this.draft : this.lines[next];
  }
}

/** @returns {string[]} */
function kept() {
  try {
    const lines = JSON.parse(remembered(KEY) ?? "[]");
    return Array.isArray(lines) ? lines.filter((line) => typeof line === "string") : [];
  } catch {
    return [];
  }
}

export class Field {
  /** Usage of every command, asked once. @type {Map<string, string>|null} */
  usages = null;

  /** @param {App} app @param {HTMLElement} element */
  constructor(app, element) {
    this.app = app;
    this.past = new Past(kept());
    this.input = h("input", {
      type: "text",
      id: "command",
      placeholder: "Type a command, or press /",
      "aria-label": "command",
      autocomplete: "off",
      autocapitalize: "off",
      spellcheck: "false",
      enterkeyhint: "go",
    });
    this.completion = new Completion(app, this.input, (text, at) => ({ text, at, shift: 0 }));
    this.usage = h("div", { class: "usage", hidden: true });
    this.output = h("div", { class: "output", role: "log", "aria-live": "polite", "aria-label": "replies", hidden: true });
    const form = h(
      "form",
      { class: "field", onsubmit: (/** @type {Event} */ event) => this._submit(event) },
      icon("prompt"),
      this.input,
      h("button", { type: "submit", class: "send", "aria-label": "run the command" }, icon("enter")),
    );
    fill(element, this.output, this.usage, this.completion.list, form);
    this.input.addEventListener("keydown", (event) => this._key(event));
    for (const type of ["input", "focus", "change-text"]) this.input.addEventListener(type, () => this._showUsage());
    this.input.addEventListener("blur", () => (this.usage.hidden = true));
    app.canvas.addEventListener("pointerdown", () => (this.output.hidden = true));
    app.wire.addEventListener("ran", () => {
      if (this.output.classList.contains("refused")) this.output.hidden = true;
    });
  }

  /** Go to the field, with a text to go on from. @param {string} [text] */
  open(text) {
    if (text !== undefined) this.input.value = text;
    this.input.focus();
    const end = this.input.value.length;
    this.input.setSelectionRange(end, end);
    this._showUsage();
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    if (this.completion.key(event)) return;
    if (event.key === "ArrowUp" || event.key === "ArrowDown") {
      const line = this.past.go(event.key === "ArrowUp" ? -1 : 1, this.input.value);
      if (line !== null) this.input.value = line;
      event.preventDefault();
      this._showUsage();
    } else if (event.key === "Escape") {
      this.output.hidden = true;
      this.app.canvas.focus();
      event.stopPropagation();
    }
  }

  /** @param {Event} event */
  async _submit(event) {
    event.preventDefault();
    // The key of the field, pressed in the field.
    const text = this.input.value.trim().replace(/^\/+\s*/, "");
    if (!text) return;
    this.completion.close();
    this.usage.hidden = true;
    // Empty at once, for the next command; what is refused comes back to be corrected.
    this.input.value = "";
    const reply = await this.app.wire.run(text);
    if (!reply.ok && this.input.value === "") this.input.value = text;
    this.app.follow(reply.created ?? []);
    this.past.add(text);
    remember(KEY, JSON.stringify(this.past.lines));
    this._say(text, reply);
  }

  /** @param {string} text @param {import("./types.js").Reply} reply */
  _say(text, reply) {
    const { store } = this.app;
    const close = h(
      "button",
      { class: "close", "aria-label": "close the reply", onclick: () => (this.output.hidden = true) },
      icon("close"),
    );
    if (reply.ok) {
      const lines = [reply.text, ...(reply.notes ?? [])].filter(Boolean).join("\n") || "Done";
      fill(this.output, h("code", { class: "line" }, text), h("pre", {}, ...mentioning(store, lines)), close);
    } else {
      fill(this.output, failure(this.app, reply, text), close);
      const { from, to } = reply.error ?? {};
      if (typeof from === "number" && typeof to === "number" && this.input.value === text) this.input.setSelectionRange(from, to);
    }
    this.output.classList.toggle("refused", !reply.ok);
    this.output.hidden = false;
    this.output.scrollTop = 0;
  }

  async _showUsage() {
    const part = this.input.value.slice(this.input.value.lastIndexOf(";") + 1).trim();
    const word = part.replace(/^[\w, ]+=\s*(?=[a-z_]+\s)/, "").split(/\s/, 1)[0];
    const complete = part.length > word.length || /\s$/.test(this.input.value);
    const usages = word && complete ? await this._usages() : null;
    const usage = usages?.get(word);
    this.usage.textContent = usage ?? "";
    this.usage.hidden = !usage || this.input.ownerDocument.activeElement !== this.input;
  }

  /** @returns {Promise<Map<string, string>>} */
  async _usages() {
    if (this.usages) return this.usages;
    const reply = await this.app.wire.ask("table");
    const data = /** @type {{commands: {name: string, aliases: string[], usage: string[]}[]}|undefined} */ (reply.data);
    if (!reply.ok || !data) return new Map();
    this.usages = new Map();
    for (const one of data.commands) {
      for (const word of [one.name, ...one.aliases]) this.usages.set(word, one.usage.join("\n"));
    }
    return this.usages;
  }
}
