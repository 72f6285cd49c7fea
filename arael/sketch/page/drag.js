/** A drag of geometry: places go to the server, at most one at a time; its frames come back as a view. */

/** @typedef {import("./types.js").Point} Point */

/** How often it is looked whether a frame is late, milliseconds. */
const WATCH = 50;

export class DragControl {
  active = false;
  _timer = 0;

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
  }

  /**
   * Begin to drag points, curves or an arc's radius.
   * @param {string[]} handles
   * @param {Point} at
   */
  async begin(handles, at) {
    const { app } = this;
    this.active = true;
    this._timer = window.setInterval(() => app.renderer.late(app.wire.delay), WATCH);
    const reply = await app.wire.beginDrag(handles, at);
    if (reply.ok) return;
    this._end();
    app.dispatchEvent(new CustomEvent("refused", { detail: { text: "drag", reply } }));
  }

  /** @param {Point} at */
  to(at) {
    if (this.active) this.app.wire.dragTo(at);
  }

  /** End it: one step of undo. */
  async drop() {
    if (!this.active) return;
    this._end();
    const reply = await this.app.wire.drop();
    if (!reply.ok) this.app.dispatchEvent(new CustomEvent("refused", { detail: { text: "drag", reply } }));
  }

  /** Take it back. */
  cancel() {
    if (!this.active) return;
    this._end();
    void this.app.wire.drop(true);
  }

  _end() {
    this.active = false;
    window.clearInterval(this._timer);
    this.app.renderer.late(0);
  }
}
