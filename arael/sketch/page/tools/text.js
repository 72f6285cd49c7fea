/** Texts: the left end of the base line, then the words, which are lettered while they are typed. */

import { widthOf } from "../geometry/lettering.js";
import { add } from "../geometry/vectors.js";
import { coordinate, extras, quoted, short } from "./compose.js";
import { PointsTool } from "./points.js";

/** Height of capitals; 0 until one was chosen. */
let height = 0;
/** Pixels of a height that nobody chose. */
const PIXELS = 24;
/** What is shown before anything is typed. */
const SAMPLE = "Text";

export class TextTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "text", title: "Text", key: "Shift+G", group: "create",
    hint: "left end of the base line, then the words; type the height before",
    make: (app) => new TextTool(app),
  };

  words = "";

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["left end of the base line of the text; type its height"]);
  }

  get height() {
    const typed = this.typed.number("height", height || nice(PIXELS / this.app.view.scale));
    return typed > 0 ? typed : height;
  }

  fields() {
    return this.begun ? [] : [this.field("height", "height", this.height)];
  }

  /** Enter after the height only takes the height. */
  text() {
    this.stepDone();
  }

  stepDone() {
    height = this.height;
    this.typed.clear();
    this.app.renderer.overlayChanged();
  }

  async commit() {
    const [place] = this.places;
    this.stepDone();
    this.app.openTyping({
      at: this.app.view.toScreen(place.at), title: "text", text: "",
      change: (text) => {
        this.words = text;
        this.app.renderer.overlayChanged();
      },
      commit: async (text) => {
        const command = `add_text ${coordinate(place.at)} ${quoted(text)} height ${short(height)} noconnect`;
        const reply = await this.app.wire.run(command, { extras: extras(place, "_.p1") });
        if (reply.ok) this.cancel();
        return reply;
      },
      cancel: () => this.cancel(),
    });
  }

  cancel() {
    super.cancel();
    this.words = "";
    this.app.renderer.overlayChanged();
  }

  preview() {
    const [a] = this.all.map((place) => place.at);
    if (!a) return {};
    const text = this.words.trim() || SAMPLE;
    const to = add(a, [this.height * widthOf(text), 0]);
    return { points: [a], texts: [{ text, from: a, to }] };
  }
}

/** The largest of 1, 2, 5 times a power of ten that is not above a number. @param {number} x */
function nice(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return Number(([5, 2].find((f) => f * power <= x) ?? 1) * Number(power.toPrecision(1))) || 1;
}
