/** Text outlines: a place and a height, then the words are typed. */

import { line } from "../geometry/curves.js";
import { coordinate, number } from "./compose.js";
import { PointsTool } from "./points.js";

export class TextTool extends PointsTool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "text", title: "Text", key: "Shift+G", group: "create", hint: "place and height of a text, then the words",
    make: (app) => new TextTool(app),
  };

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super(app, ["lower left corner of the text", "its height"]);
  }

  async commit() {
    const [a, b] = this.places.map((place) => place.at);
    const height = Math.abs(b[1] - a[1]) || Math.abs(b[0] - a[0]);
    this.cancel();
    this.stepped();
    this.app.openTyping({
      at: this.app.view.toScreen(a), title: "text", text: "",
      commit: (text) => this.app.run(`add_text ${coordinate(a)} ${number(height)} "${text.replaceAll('"', "'")}"`),
    });
  }

  preview() {
    const [a, b] = this.all.map((place) => place.at);
    return { points: a ? [a] : [], guides: b ? [line(a, [b[0], a[1]]), line([a[0], b[1]], b)] : [] };
  }
}
