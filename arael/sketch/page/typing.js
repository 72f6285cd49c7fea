/** A value typed in place over the drawing: expression, units, completion; an error stays in place. */

import { Completion } from "./completion.js";
import { fill, h, later } from "./dom.js";
import { quantityOf } from "./draw/texts.js";
import { failure } from "./failure.js";
import { amount, linked, quoted } from "./tools/compose.js";

/**
 * @typedef {import("./app.js").App} App
 * @typedef {import("./app.js").TypingRequest} TypingRequest
 * @typedef {import("./types.js").Reply} Reply
 */

const WIDTH = 240;

/** The button for a dimension that only measures. @param {string} value  that it has now */
export const asReference = (value) => (value ? `as reference (${value})` : "as reference");

export class Typing {
  /** @type {TypingRequest|null} */
  request = null;

  /** @param {App} app @param {HTMLElement} stage */
  constructor(app, stage) {
    this.app = app;
    this.title = h("label", { class: "typing-title", for: "typed" });
    this.input = h("input", { type: "text", id: "typed", autocomplete: "off", autocapitalize: "off", spellcheck: "false" });
    this.value = h("output", { class: "typing-value", for: "typed" });
    this.problem = h("div", { class: "typing-problem", role: "alert" });
    this.completion = new Completion(app, this.input, (text, at) => {
      if (this.request?.change) return { text: "", at: 0, shift: 0 };
      return { text, at, shift: 0, value: true };
    });
    this.element = h(
      "form",
      { class: "typing", hidden: true, onsubmit: (/** @type {Event} */ event) => this._enter(event) },
      this.title,
      h("div", { class: "typing-row" }, this.input, this.value),
      this.completion.list,
      this.problem,
    );
    stage.append(this.element);
    const evaluate = later(120, () => this._evaluate());
    this.input.addEventListener("input", () => {
      fill(this.problem);
      this.request?.change?.(this.input.value);
      this.request?.write?.(this.input.value, NaN);
      evaluate();
    });
    this.input.addEventListener("change-text", evaluate);
    this.input.addEventListener("keydown", (event) => this._key(event));
    this.element.addEventListener("focusout", (event) => this._left(event));
    app.view.addEventListener("change", () => this.close(true));
  }

  /** Ask for a value. @param {TypingRequest} request */
  open(request) {
    this.request = request;
    this.title.textContent = request.title;
    this.input.value = request.text;
    this.value.textContent = "";
    fill(this.problem);
    this.element.hidden = false;
    this._place(request.at);
    this.input.focus();
    if (request.begun) {
      const end = request.text.length;
      this.input.setSelectionRange(end, end);
      this.input.dispatchEvent(new Event("input"));
    } else this.input.select();
    this._evaluate();
  }

  /** End without a value, or with the one that is written already. @param {boolean} [keep] */
  close(keep = false) {
    const { request } = this;
    if (!request) return;
    this.request = null;
    this.completion.close();
    const focused = this.element.contains(this.element.ownerDocument.activeElement);
    this.element.hidden = true;
    if (!keep || !request.write) request.cancel?.();
    if (focused) this.app.canvas.focus();
  }

  /**
   * Edit the value of a dimension.
   * @param {string} name
   */
  edit(name) {
    const record = this.app.store.dimensions.get(name);
    if (!record) return;
    this.open({
      name,
      at: this._drawn(name) ?? this._middle(record.args),
      title: `${name}: ${record.kind} ${record.args.join(" ")}`,
      text: this.app.store.lengths.amount(record),
      quantity: quantityOf(record.kind),
      command: (text) => `set_driven ${name} ${amount(text)}`,
      commit: (text) => this.app.wire.run(`set_driven ${name} ${amount(text)}`),
    });
  }

  /** Edit what a text reads. @param {import("./types.js").Entity} frame */
  editText({ name, text = "" }) {
    this.open({
      at: this._middle([name]), title: `${name}: text`, text, change: () => {},
      commit: (typed) => this.app.wire.run(`set_text ${name} ${quoted(typed)}`),
    });
  }

  /**
   * Add a dimension: the value that it has now is offered.
   * @param {import("./actions/dimensions.js").DimensionSpec} spec
   * @param {string[]} names
   */
  async add(spec, names) {
    const expression = spec.present(names, this.app.store);
    const reply = expression ? await this.app.wire.ask("evaluate", { text: expression }) : null;
    const quantity = quantityOf(spec.id);
    const text = reply?.ok ? this._told(reply, quantity) : "";
    this.open({
      at: this._middle(names),
      title: `${spec.title} ${names.join(" ")}`,
      text,
      given: reply?.ok ? reply.text : "",
      quantity,
      reference: { command: `${spec.id} ${names.join(" ")} derived`, title: asReference(text) },
      command: (text) => `${spec.id} ${names.join(" ")} ${amount(text)}`,
      commit: (text) => this.app.wire.run(`${spec.id} ${names.join(" ")} ${amount(text)}`),
    });
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    if (this.completion.key(event)) return;
    if (event.key === "Escape") this.close();
    else if (event.key === "Tab" && this.request?.next) this._goOn(event.shiftKey ? -1 : 1);
    else if (event.key === "Tab" && this.request?.name) this._enter(event, event.shiftKey ? -1 : 1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {-1|1} step */
  _goOn(step) {
    const { request } = this;
    this.close(true);
    request?.next?.(step);
  }

  /**
   * @param {Event} event
   * @param {-1|0|1} step  to the next or previous dimension
   */
  async _enter(event, step = 0) {
    event.preventDefault();
    const { request } = this;
    const text = this.input.value.trim();
    if (!request) return;
    const changed = text !== request.text || !request.name;
    const meant = this._meant(text, request);
    const reply = changed ? await this._commit(request, meant) : { ok: true, text: "" };
    if (this.request !== request) return;
    if (!reply.ok) {
      this._refused(reply, meant);
      return;
    }
    const next = step && request.name ? this._neighbour(request.name, step) : "";
    this.request = null;
    this.element.hidden = true;
    this.app.dispatchEvent(new CustomEvent("ran", { detail: { text, reply } }));
    if (next) this.edit(next);
    else this.app.canvas.focus();
  }

  /** @param {TypingRequest} request @param {string} meant @returns {Promise<Reply>} */
  async _commit(request, meant) {
    const { write } = request;
    if (write && !isBound(meant)) {
      const value = await this.app.wire.ask("evaluate", { text: linked(meant) });
      if (!value.ok) return value;
      write(this.input.value, numberOf(value));
    }
    return request.commit(meant);
  }

  /** @param {Reply} reply @param {string} text */
  _refused(reply, text) {
    const { command, reference } = this.request ?? {};
    const done = () => {
      this.request = null;
      this.element.hidden = true;
      this.app.canvas.focus();
    };
    fill(this.problem, failure(this.app, reply, "", command?.(text) ?? "", { reference, done }));
    const { from, to } = reply.error ?? {};
    // the place is one of the whole command, the text its end, in quotes if it is more than a word
    const source = this.request?.name ? `set_driven ${this.request.name} ${amount(text) === text ? "" : '"'}` : "";
    if (source && typeof from === "number" && typeof to === "number" && from >= source.length) {
      this.input.setSelectionRange(from - source.length, to - source.length);
    } else this.input.setSelectionRange(0, text.length);
    this.input.focus();
  }

  /** What the text is, if it is more than a number. */
  async _evaluate() {
    const text = this.input.value.trim();
    const { request } = this;
    const plain = request?.change || text === "" || Number.isFinite(Number(text)) || isBound(text);
    const meant = request ? this._meant(text, request) : text;
    const reply = plain ? null : await this.app.wire.ask("evaluate", { text: linked(meant) });
    if (this.request !== request || this.input.value.trim() !== text) return;
    if (reply?.ok) request?.write?.(this.input.value, numberOf(reply));
    this.value.textContent = reply?.ok ? `= ${this._told(reply, request?.quantity)}` : "";
  }

  /** What was typed, as commands read it. @param {string} text @param {TypingRequest} request */
  _meant(text, { quantity, given, text: offered }) {
    if (given && text === offered) return given;
    return quantity ? this.app.store.lengths.typed(text, quantity) : text;
  }

  /** A value that was asked for, as lengths are shown. @param {Reply} reply @param {import("./lengths.js").Quantity} [quantity] */
  _told(reply, quantity) {
    const number = numberOf(reply);
    return quantity && Number.isFinite(number) ? this.app.store.lengths.text(number, quantity) : reply.text;
  }

  /**
   * The dimension after or before another one.
   * @param {string} name
   * @param {number} step
   */
  _neighbour(name, step) {
    const names = [...this.app.store.dimensions.values()].filter((one) => !one.derived).map((one) => one.name);
    const at = names.indexOf(name);
    return names.length > 1 && at >= 0 ? names[(at + step + names.length) % names.length] : "";
  }

  /** Where the text of a dimension is drawn. @param {string} name @returns {[number, number]|null} */
  _drawn(name) {
    const found = this.app.renderer.annotations.dimensions.find((one) => one.name === name);
    return found ? [found.text.x, found.text.y] : null;
  }

  /**
   * Pixels in the middle of what a dimension measures.
   * @param {string[]} handles
   * @returns {[number, number]}
   */
  _middle(handles) {
    const { store, view } = this.app;
    let [x, y, count] = [0, 0, 0];
    for (const handle of handles) {
      const at = store.point(handle);
      const numbers = at ?? store.numbers(handle);
      const pairs = at || !store.entities.get(handle)?.kind.startsWith("line") ? 1 : 2;
      for (let i = 0; i < pairs && numbers.length >= 2 * i + 2; i++) {
        x += numbers[2 * i];
        y += numbers[2 * i + 1];
        count += 1;
      }
    }
    return count ? view.toScreen([x / count, y / count]) : [view.width / 2, view.height / 2];
  }

  /** @param {[number, number]} at  pixels of the canvas */
  _place(at) {
    const { view } = this.app;
    const x = Math.min(Math.max(at[0] - WIDTH / 2, 8), Math.max(view.width - WIDTH - 8, 8));
    const y = Math.min(Math.max(at[1] + 14, 8), Math.max(view.height - 130, 8));
    this.element.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
  }

  /** @param {FocusEvent} event */
  _left(event) {
    const to = /** @type {Node|null} */ (event.relatedTarget);
    if (to && !this.element.contains(to)) this.close(true);
  }
}

/** Whether a value is a bound or a range. @param {string} text */
const isBound = (text) => />=|<=|\bto\b/.test(text);

/** Value of an answer, NaN if it has none. @param {Reply} reply */
function numberOf(reply) {
  const number = /** @type {{value?: unknown}|undefined} */ (reply.data)?.value;
  return typeof number === "number" ? number : NaN;
}
