/** The table of tools, and the one that is active. */

import { ARCS } from "./arcs.js";
import { CIRCLES } from "./circles.js";
import { CollectTool } from "./collect.js";
import { CORNERS } from "./corners.js";
import { CUTS } from "./cuts.js";
import { DimensionTool } from "./dimension.js";
import { ELLIPSES } from "./ellipses.js";
import { LineTool } from "./line.js";
import { MeasureTool } from "./measure.js";
import { MirrorTool } from "./mirror.js";
import { OffsetTool } from "./offset.js";
import { PATTERNS } from "./patterns.js";
import { PointTool } from "./point.js";
import { PolygonTool } from "./polygon.js";
import { RECTANGLES } from "./rectangles.js";
import { SelectTool } from "./select.js";
import { SlotTool } from "./slot.js";
import { SplineTool, ThroughTool } from "./spline.js";
import { TextTool } from "./text.js";
import { TRANSFORMS } from "./transforms.js";

/**
 * @typedef {import("../types.js").ToolSpec} ToolSpec
 * @typedef {import("./tool.js").Tool} Tool
 */

/** All tools in the order in which they are offered. @type {readonly ToolSpec[]} */
export const TOOLS = [
  SelectTool.spec,
  LineTool.spec,
  ...RECTANGLES,
  ...CIRCLES,
  ...ARCS,
  ...ELLIPSES,
  SplineTool.spec,
  ThroughTool.spec,
  SlotTool.spec,
  PolygonTool.spec,
  PointTool.spec,
  TextTool.spec,
  DimensionTool.spec,
  MeasureTool.spec,
  ...CORNERS,
  ...CUTS,
  OffsetTool.spec,
  MirrorTool.spec,
  ...PATTERNS,
  ...TRANSFORMS,
];

/** Events: "tool" when another one is active. */
export class Toolbox extends EventTarget {
  id = "select";
  table = TOOLS;

  /** @param {import("../app.js").App} app */
  constructor(app) {
    super();
    this.app = app;
    /** @type {Tool} */
    this.current = SelectTool.spec.make(app);
  }

  /** The entry of a tool. @param {string} id */
  spec(id) {
    return TOOLS.find((tool) => tool.id === id) ?? SelectTool.spec;
  }

  /** Activate a tool. @param {string} id */
  start(id) {
    const spec = this.spec(id);
    this._use(spec, spec.make);
  }

  /** Pick what a constraint or dimension needs, then make it. @param {import("../actions.js").Action} action */
  collect(action) {
    const spec = { ...SelectTool.spec, id: action.id, title: action.title, hint: "" };
    this._use(spec, (app) => new CollectTool(app, action));
  }

  /** @param {import("../types.js").ToolSpec} spec @param {(app: import("../app.js").App) => Tool} make */
  _use(spec, make) {
    const place = this.current.place;
    this.current.leave();
    this.id = spec.id;
    this.current = make(this.app);
    if (place) this.current.place = place;
    this.dispatchEvent(new CustomEvent("tool", { detail: spec }));
    this.current.stepped();
  }

  /** Escape: drop what was begun, else go back to selecting, else clear the selection. */
  cancel() {
    if (this.current.begun || this.current.typed.any) {
      this.current.cancel();
      this.current.stepped();
    } else if (this.id !== "select") this.start("select");
    else if (this.app.store.selection.size) this.app.store.select([]);
  }

  /**
   * A key: typed values first, then the tool.
   * @param {KeyboardEvent} event
   * @returns {boolean} whether it was used
   */
  key(event) {
    const tool = this.current;
    if (event.key === "Escape") {
      this.cancel();
      return true;
    }
    const typed = tool.typed.key(event, tool.fields(), tool.begun);
    if (typed === "expression") {
      this.express(event.key);
      return true;
    }
    if (typed) {
      if (typed === "enter") tool.text(tool.typed.text(tool.fields()[tool.typed.active]?.id ?? ""));
      this.app.renderer.overlayChanged();
      return true;
    }
    if (tool.key(event)) return true;
    if (event.key === "Enter" && this.id !== "select") {
      tool.finish();
      return true;
    }
    return false;
  }
  /** The value that is typed goes on in a field over the drawing, where names complete. @param {string} [more]  what is typed next @param {number} [index]  of the field */
  express(more = "", index = this.current.typed.active) {
    const { app, current: tool } = this;
    const fields = tool.fields();
    const { typed } = tool;
    if (!fields.length) return;
    typed.active = Math.min(index, fields.length - 1);
    const field = fields[typed.active];
    const { id, title, quantity } = field;
    /** @param {string} text @param {number} [number] */
    const write = (text, number) => {
      typed.write(field, text, number);
      if (tool.place) tool.move(tool.place);
      app.renderer.overlayChanged();
    };
    const text = (typed.texts.get(id) ?? "") + more;
    write(text);
    app.openTyping({
      at: tool.place?.screen ?? [app.view.width / 2, app.view.height / 2],
      title, text, begun: true,
      quantity: quantity === "length" || quantity === "angle" ? quantity : undefined,
      write,
      next: (step) => {
        typed.active = (typed.active + step + fields.length) % fields.length;
        this.express();
      },
      commit: async () => {
        typed.open = false;
        tool.text(typed.text(id));
        return { ok: true, text: "" };
      },
      cancel: () => write(""),
    });
  }
}
