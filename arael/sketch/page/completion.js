/** Completion below a text field: a list of words that arrow keys and Tab choose from. */

import { fill, h, later } from "./dom.js";

const WAIT = 80;
let count = 0;

/**
 * A text with a word in place of a stretch, and where the caret comes to stand.
 * @param {string} text
 * @param {{from: number, to: number}} stretch
 * @param {string} word
 * @returns {{text: string, caret: number}}
 */
export function replaced(text, stretch, word) {
  const after = text.slice(stretch.to);
  const space = after.startsWith(" ") || after === "" ? "" : " ";
  return { text: text.slice(0, stretch.from) + word + space + after, caret: stretch.from + word.length };
}

/** Words for one field. */
export class Completion {
  /** @type {string[]} */
  words = [];
  chosen = -1;

  /**
   * @param {import("./app.js").App} app
   * @param {HTMLInputElement} input
   * @param {(text: string, caret: number) => {text: string, at: number, shift: number, value?: boolean}} line  the
   *     command line (or the value) that the server completes, the caret in it, and where the field's text begins in it
   */
  constructor(app, input, line) {
    this.app = app;
    this.input = input;
    this.line = line;
    this.id = `words-${++count}`;
    this.list = h("ul", { class: "words", role: "listbox", id: this.id, hidden: true, "aria-label": "completions" });
    this.stretch = { from: 0, to: 0 };
    input.setAttribute("role", "combobox");
    input.setAttribute("aria-autocomplete", "list");
    input.setAttribute("aria-controls", this.id);
    input.setAttribute("aria-expanded", "false");
    const ask = later(WAIT, () => this._ask());
    input.addEventListener("input", ask);
    input.addEventListener("blur", () => this.close());
  }

  get isOpen() {
    return this.words.length > 0;
  }

  close() {
    this.words = [];
    this._show();
  }

  /**
   * A key of the field.
   * @param {KeyboardEvent} event
   * @returns {boolean} whether it was used
   */
  key(event) {
    if (!this.isOpen) return false;
    const { length } = this.words;
    if (event.key === "ArrowDown") this._choose((this.chosen + 1) % length);
    else if (event.key === "ArrowUp" && this.chosen >= 0) this._choose(this.chosen - 1);
    else if (event.key === "Tab" && !event.shiftKey) this.take(Math.max(this.chosen, 0));
    else if (event.key === "Enter" && this.chosen >= 0) this.take(this.chosen);
    else if (event.key === "Escape") this.close();
    else return false;
    event.preventDefault();
    event.stopPropagation();
    return true;
  }

  /** Write a word into the field. @param {number} index */
  take(index) {
    const { text, caret } = replaced(this.input.value, this.stretch, this.words[index]);
    this.input.value = text;
    this.input.setSelectionRange(caret, caret);
    this.close();
    this.input.focus();
    this.input.dispatchEvent(new Event("change-text"));
  }

  async _ask() {
    const caret = this.input.selectionStart ?? this.input.value.length;
    const asked = this.input.value;
    const { text, at, shift, value } = this.line(asked, caret);
    if (!/[\w.]$/.test(text.slice(0, at))) {
      this.close();
      return;
    }
    const reply = await this.app.wire.ask("complete", { text, at, value });
    if (this.input.value !== asked || this.input.ownerDocument.activeElement !== this.input) return;
    const data = /** @type {{from: number, to: number, words: string[]}|undefined} */ (reply.data);
    this.words = reply.ok && data ? data.words.slice(0, 12) : [];
    this.stretch = { from: (data?.from ?? at) - shift, to: (data?.to ?? at) - shift };
    this.chosen = -1;
    this._show();
  }

  /** @param {number} index */
  _choose(index) {
    this.chosen = index;
    this._show();
  }

  _show() {
    this.list.hidden = !this.isOpen;
    this.input.setAttribute("aria-expanded", String(this.isOpen));
    const options = this.words.map((word, i) =>
      h(
        "li",
        {
          role: "option",
          id: `${this.id}-${i}`,
          "aria-selected": String(i === this.chosen),
          // before the field loses the focus
          onpointerdown: (/** @type {Event} */ event) => {
            event.preventDefault();
            this.take(i);
          },
        },
        word,
      ),
    );
    fill(this.list, ...options);
    if (this.chosen >= 0) this.input.setAttribute("aria-activedescendant", `${this.id}-${this.chosen}`);
    else this.input.removeAttribute("aria-activedescendant");
  }
}
