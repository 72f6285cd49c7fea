/** The dimension tool: what is picked and where the text is put decide which kind it is. */

import { layoutDimension, measured } from "../draw/dimensions.js";
import { Places } from "../draw/places.js";
import { dimensionText, quantityOf } from "../draw/texts.js";
import { splitHandle } from "../geometry/handles.js";
import { asReference } from "../typing.js";
import { amount, short } from "./compose.js";
import { kindsOf } from "./kinds.js";
import { CURVES, PicksTool } from "./picks.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Dimension} Dimension
 */

export class DimensionTool extends PicksTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "dimension", title: "Dimension", key: "d", group: "dimension",
    hint: "pick a curve, or two things; then the place of the text; Space takes another kind",
    make: (app) => new DimensionTool(app),
  };

  /** Which of the kinds that fit is meant; -1: as the pointer lies. */
  choice = -1;
  /** The dimension whose value is being typed. @type {Dimension|null} */
  asked = null;

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["point", "pointlike", ...CURVES], 2);
    const names = [...app.store.selection].filter((name) => app.store.entities.has(splitHandle(name)[0]));
    if (names.length <= 2 && names.every((name) => !app.store.constraints.has(name))) this.names = names;
  }

  get hint() {
    if (!this.names.length) return "a curve or a point";
    return this.names.length === 1 ? "a second one, or the place of the text; Space: another kind" : "place of the text; Space: another kind";
  }

  get picks() {
    return true;
  }

  /** @param {Place} place */
  click(place) {
    this.place = place;
    const pick = this.picking ? this.app.picker.at(place.screen, (one) => this.accepts(one)) : null;
    const names = pick ? [...this.names, pick.name] : [];
    const first = pick?.type === "point" && !this.names.length;
    if (pick && (first || kindsOf(this.app.store, names, place.at).length)) {
      this.names.push(pick.name);
      this.choice = -1;
      this.stepped();
    } else if (this.names.length) this.ask(place);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.key !== " " || !this.names.length || !this.place) return false;
    const count = kindsOf(this.app.store, this.names, this.place.at).length;
    this.choice = count ? (this.choice + 1) % count : -1;
    this.app.renderer.overlayChanged();
    return true;
  }

  finish() {
    if (this.names.length && this.place) this.ask(this.place);
  }

  /** The dimension as it would be made now. @returns {Dimension|null} */
  get record() {
    if (this.asked) return this.asked;
    if (!this.place) return null;
    const kinds = kindsOf(this.app.store, this.names, this.place.at);
    const chosen = kinds[Math.max(this.choice, 0)];
    if (!chosen) return null;
    /** @type {Dimension} */
    const d = { name: "", kind: chosen.kind, args: chosen.args, ...(chosen.mode ? { mode: chosen.mode } : {}) };
    const number = measured(this.app.store, d) ?? 0;
    const value = Number((d.kind === "angle" ? Math.abs(number) : number).toPrecision(6));
    const full = { ...d, value: { text: String(value), number: value } };
    const drawn = layoutDimension(this.pen, full, this.textOf(full));
    return { ...full, ...drawn?.placeAt(this.place.screen) };
  }

  /** @param {Dimension} d */
  textOf(d) {
    return dimensionText(d, this.app.store.lengths);
  }

  /** Lays out the preview: nothing else is in its way. */
  get pen() {
    return {
      store: this.app.store, view: this.app.view, places: new Places(),
      middle: /** @type {[number, number]} */ ([0, 0]),
      width: (/** @type {string} */ text) => 7 * text.length,
    };
  }

  /** Ask for the value at the place of the text. @param {Place} place */
  ask(place) {
    this.place = place;
    const { record } = this;
    if (!record) return;
    this.stepped();
    /** @type {string[]} */
    const extras = [];
    // the name that the next dimension gets
    const name = nextName(this.app.store);
    if (typeof record.offset === "number") extras.push(`dim_pos ${name} offset ${short(record.offset)}`);
    if (typeof record.along === "number" && record.along !== 0) extras.push(`dim_pos ${name} along ${short(record.along)}`);
    const made = `${record.kind} ${record.args.join(" ")}`;
    const mode = record.mode ? ` ${record.mode}` : "";
    const { lengths } = this.app.store;
    const quantity = quantityOf(record.kind);
    const value = lengths.amount(record);
    const end = () => {
      this.cancel();
      this.app.renderer.overlayChanged();
    };
    // The preview stays while the value is typed.
    this.asked = record;
    this.app.openTyping({
      at: place.screen, title: record.kind, text: value, given: record.value?.text ?? "", quantity,
      reference: { command: [`${made} derived${mode}`, ...extras].join("; "), title: asReference(value) },
      command: (text) => [`${made} ${amount(text)}${mode}`, ...extras].join("; "),
      commit: async (text) => {
        const reply = await this.app.wire.run(`${made} ${amount(text)}${mode}`, { extras });
        if (reply.ok) end();
        return reply;
      },
      cancel: end,
    });
  }

  cancel() {
    super.cancel();
    this.choice = -1;
    this.asked = null;
  }

  preview() {
    const preview = super.preview();
    const { record } = this;
    const drawn = record && layoutDimension(this.pen, record, this.textOf(record));
    return drawn ? { ...preview, dimension: drawn } : preview;
  }
}

/** The name that the next dimension gets. @param {import("../store.js").Store} store */
const nextName = (store) => `d${store.settings["counter:d"] ?? 0}`;
