/** Picks things until a constraint or dimension that was chosen before them can be made. */

import { splitHandle } from "../geometry/handles.js";
import { Tool } from "./tool.js";

/**
 * @typedef {import("../types.js").Place} Place
 * @typedef {import("../actions.js").Action} Action
 */

/** What is picked is the selection, on which the action works. */
export class CollectTool extends Tool {
  /** What is under the pointer. */
  under = "";

  /** @param {import("../app.js").App} app @param {Action} action */
  constructor(app, action) {
    super(app);
    this.action = action;
    const { store } = app;
    const names = [...store.selection].filter((name) => store.entities.has(splitHandle(name)[0]));
    store.select(names.length < this.most ? names : []);
  }

  /** How many things are picked at most before it must fit. */
  get most() {
    return this.action.most ?? 2;
  }

  get hint() {
    const enter = this.action.chain ? ", then Enter" : "";
    return `${this.action.title}: pick ${this.action.needs}${enter}`;
  }

  get picks() {
    return true;
  }

  get begun() {
    return this.app.store.selection.size > 0;
  }

  /** @param {Place} place */
  pick(place) {
    return this.app.picker.at(place.screen, (one) => one.type === "point" || one.type === "curve");
  }

  /** @param {Place} place */
  move(place) {
    this.under = this.pick(place)?.name ?? "";
    this.app.store.hover(this.under ? [this.under] : []);
    super.move(place);
  }

  /** @param {Place} place */
  click(place) {
    const name = this.pick(place)?.name;
    if (!name) return;
    const { app, action } = this;
    const { store } = app;
    store.select([name], "toggle");
    if (action.chain) return;
    if (app.actions.isEnabled(action)) this.act();
    else if (store.selection.size >= this.most) {
      // it does not fit: the newest one begins anew
      app.actions.refuse(action);
      store.select([name]);
    }
  }

  // the second click of a double click would take back what the first has picked
  doubleClick() {}

  finish() {
    if (this.app.actions.isEnabled(this.action)) this.act();
  }

  /** Make it; the tool stays for the next one. */
  act() {
    const { app, action } = this;
    action.run(app);
    app.store.select([]);
    app.store.hover([]);
    this.stepped();
  }

  cancel() {
    super.cancel();
    this.app.store.hover([]);
    this.app.store.select([]);
  }

  leave() {
    this.typed.clear();
    this.app.store.hover([]);
  }
}
