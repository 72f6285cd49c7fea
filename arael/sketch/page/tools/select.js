/** Selecting, and dragging what is there: points, curves, radii, texts of dimensions, glyphs; boxes on empty ground. */

import { numberText } from "../draw/texts.js";
import { chainOf } from "../geometry/chains.js";
import { regionAt } from "../geometry/regions.js";
import { openFitting } from "../menu.js";
import { short } from "./compose.js";
import { Tool } from "./tool.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../pick.js").Pick} Pick
 * @typedef {"none"|"geometry"|"dimension"|"glyph"|"box"} Grab
 */

/** Pixels that the pointer moves before a press becomes a drag. */
const SLACK = 4;

export class SelectTool extends Tool {
  /** @type {import("../types.js").ToolSpec} */
  static spec = {
    id: "select", title: "Select", key: "Escape", group: "select",
    hint: "click to select, drag to move; double click selects what is connected",
    make: (app) => new SelectTool(app),
  };

  /** What is pressed. @type {Pick|null} */
  held = null;
  /** @type {Place|null} */
  from = null;
  /** @type {Grab} */
  grab = "none";
  /** What was said of the place of the pointer. */
  told = "";
  /** Which of the things that overlap is meant. */
  cycle = 0;

  get hint() {
    return SelectTool.spec.hint;
  }

  get grabs() {
    return true;
  }

  get picks() {
    return true;
  }

  get begun() {
    return this.grab !== "none";
  }

  /** What a drag moves is painted by its frames. */
  get follows() {
    return this.grab !== "geometry";
  }

  /** What is under the pointer: the one that Tab chose. @param {Point} screen @returns {Pick|null} */
  pick(screen) {
    const all = this.app.picker.all(screen);
    return all.length ? all[this.cycle % all.length] : null;
  }

  /** @param {Place} place */
  down(place) {
    this.from = place;
    this.held = this.pick(place.screen);
  }

  /** @param {Place} place @param {PointerEvent|null} [event] */
  move(place, event) {
    const before = this.place?.screen;
    if (before && Math.hypot(before[0] - place.screen[0], before[1] - place.screen[1]) > 3) this.cycle = 0;
    super.move(place, event);
    const { from } = this;
    if (!from) {
      const pick = this.pick(place.screen);
      this.app.store.hover(pick ? [pick.name] : []);
      this.tell(pick ? null : place.at);
      this.app.canvas.style.cursor = pick ? (pick.type === "curve" || pick.type === "point" ? "move" : "pointer") : "";
      return;
    }
    const moved = Math.hypot(place.screen[0] - from.screen[0], place.screen[1] - from.screen[1]);
    if (this.grab === "none" && moved > SLACK) this.begin(from);
    this.follow(place);
  }

  /** Area and perimeter of the region under the pointer. @param {Point|null} at */
  tell(at) {
    const { app } = this;
    const region = at && app.shown.regions ? regionAt(app.renderer.tint.found.loops, at) : null;
    const { unit } = app.store;
    const number = (/** @type {number} */ value) => numberText(Number(value.toPrecision(5)));
    const text = region ? `region: area ${number(region.area)} ${unit}², perimeter ${number(region.perimeter)} ${unit}` : this.hint;
    if (text === this.told) return;
    this.told = text;
    app.say(text);
  }

  /** A press has become a drag. @param {Place} from */
  begin(from) {
    const { held, app } = this;
    if (!held) this.grab = "box";
    else if (held.type === "dimension") this.grab = "dimension";
    else if (held.type === "constraint") this.grab = "glyph";
    else {
      this.grab = "geometry";
      app.store.hover([]);
      void app.drag.begin(this.handles(held), from.at);
    }
  }

  /** What a grabbed thing drags: the rim of a circle its radius, a selected curve the selection. @param {Pick} held */
  handles(held) {
    const { store } = this.app;
    if (held.type === "point") return [held.name];
    const curves = [...store.selection].filter((name) => store.entities.has(name));
    if (curves.length > 1 && curves.includes(held.name)) return curves;
    const kind = store.entities.get(held.name)?.kind;
    return [kind === "circle" || kind === "arc" ? `${held.name}.radius` : held.name];
  }

  /** @param {Place} place */
  follow(place) {
    const { app, held } = this;
    const { annotations } = app.renderer;
    if (this.grab === "geometry") app.drag.to(place.at);
    else if (this.grab === "dimension" && held) {
      const record = app.store.dimensions.get(held.name);
      const drawn = annotations.dimensions.find((one) => one.name === held.name);
      if (record && drawn) annotations.dragged = { ...record, ...drawn.placeAt(place.screen) };
      app.renderer.viewChanged();
    } else if (this.grab === "glyph" && held && this.from) {
      const [x, y] = this.from.screen;
      annotations.nudge(held.name, [place.screen[0] - x, place.screen[1] - y]);
      this.from = place;
      app.renderer.viewChanged();
    }
  }

  /** @param {Place} place @param {PointerEvent|null} event */
  up(place, event) {
    const { grab, held, from, app } = this;
    this.from = this.held = null;
    this.grab = "none";
    if (!event) return;
    if (grab === "geometry") void app.drag.drop();
    if (grab === "dimension" && held) void this.placeText(held.name);
    if (grab === "box" && from) {
      const touched = place.screen[0] < from.screen[0];
      const names = app.picker.inBox(from.screen, place.screen, touched);
      app.store.select(names, event.shiftKey || event.ctrlKey ? "add" : "replace");
    }
  }

  /** The text of a dimension was dropped. @param {string} name */
  async placeText(name) {
    const { annotations } = this.app.renderer;
    const { dragged } = annotations;
    if (!dragged) return;
    const parts = [`dim_pos ${name} offset ${short(dragged.offset ?? 0)}`];
    if (typeof dragged.along === "number") parts.push(`dim_pos ${name} along ${short(dragged.along)}`);
    await this.app.run(parts.join("; "), { step: `move the text of ${name}` });
    annotations.dragged = null;
    this.app.renderer.viewChanged();
  }

  /** @param {Place} place @param {PointerEvent|null} [event] */
  click(place, event) {
    const { store } = this.app;
    const pick = this.pick(place.screen);
    const adds = event?.shiftKey || event?.ctrlKey || event?.metaKey || event?.pointerType === "touch";
    if (pick) store.select([pick.name], adds ? "toggle" : "replace");
    else if (!event?.shiftKey && !event?.ctrlKey) store.select([]);
  }

  /** A right click: what fits what is there, or what is selected. */
  finish() {
    const { app, place } = this;
    if (!place) return;
    const pick = this.pick(place.screen);
    if (!pick) app.store.select([]);
    else if (!app.store.selection.has(pick.name)) app.store.select([pick.name]);
    openFitting(app, place.screen);
  }

  /** A dimension or text is edited, a group's marker or a curve selects what belongs to it. @param {Place} place */
  doubleClick(place) {
    const { store } = this.app;
    const pick = this.pick(place.screen);
    if (!pick) return;
    const d = store.dimensions.get(pick.name);
    const entity = store.entities.get(pick.name);
    if (d) this.app.editDimension(d);
    else if (entity?.text) this.app.editText(entity);
    else if (pick.type === "curve") store.select(chainOf(store, pick.name));
    else if (store.constraints.has(pick.name)) store.select(store.constraints.get(pick.name)?.args ?? [], "replace");
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { store } = this.app;
    if (event.key === "Tab" && this.place && !event.ctrlKey && !event.altKey) {
      const all = this.app.picker.all(this.place.screen);
      if (all.length < 2) return false;
      this.cycle = (this.cycle + (event.shiftKey ? all.length - 1 : 1)) % all.length;
      store.hover([all[this.cycle].name]);
      this.app.say(`${all[this.cycle].name}: ${this.cycle + 1} of ${all.length}`);
      return true;
    }
    if (event.key !== "Delete" && event.key !== "Backspace") return false;
    const names = deletable([...store.selection]);
    if (names.length) void this.app.run(`delete ${names.join(" ")}`);
    return names.length > 0;
  }

  cancel() {
    super.cancel();
    this.app.drag.cancel();
    this.app.renderer.annotations.dragged = null;
    this.from = this.held = null;
    this.grab = "none";
  }

  leave() {
    super.leave();
    this.app.canvas.style.cursor = "";
    this.app.store.hover([]);
  }

  preview() {
    const { from, place } = this;
    return this.grab === "box" && from && place ? { box: { from: from.screen, to: place.screen } } : {};
  }
}

/** Names to delete: of a point of a curve, the curve stays. @param {string[]} names */
const deletable = (names) => names.filter((name) => !name.includes("."));

