/** The link to the server: commands and their replies, drags, and the stream of changes. */

import { JSON_KIND, NUMBERS_KIND, decode, encodeJson, encodePointer } from "./frames.js";

/**
 * @typedef {import("./types.js").Reply} Reply
 * @typedef {import("./types.js").Point} Point
 */

const FIRST_WAIT = 250;
const LONGEST_WAIT = 4000;

/**
 * Events: "state" (`state` is "open" or "lost"), "frame" (a frame of the drag was applied), "ran" (a command
 * or drag of this window was carried out).
 */
export class Wire extends EventTarget {
  /** @type {"open"|"lost"} */
  state = "lost";
  /** @type {import("./transport.js").Connection|null} */
  _connection = null;
  /** @type {Map<number, (reply: Reply) => void>} */
  _waiting = new Map();
  _id = 0;
  _wait = FIRST_WAIT;
  _closed = false;
  // of the drag: the newest place, whether one is on its way, and since when
  /** @type {Point|null} */
  _place = null;
  /** The last place that was sent. @type {Point|null} */
  _last = null;
  _sequence = 0;
  _answered = 0;
  _sent = 0;
  _dragging = false;

  /**
   * @param {import("./store.js").Store} store
   * @param {import("./transport.js").Connect} connect
   * @param {string} [window]  identifies this window
   */
  constructor(store, connect, window = randomId()) {
    super();
    this.store = store;
    this.window = window;
    this._connect = connect;
  }

  /** Connect; connects again whenever the link is lost. */
  open() {
    if (this._closed) return;
    this._connection = this._connect(this.store.revision, {
      onopen: () => {
        this._wait = FIRST_WAIT;
        this._set("open");
      },
      onmessage: (buffer) => this._receive(buffer),
      onclose: () => this._lost(),
    });
  }

  /** Close for good. */
  close() {
    this._closed = true;
    this._connection?.close();
  }

  /**
   * Run command lines: one undo step.
   * @param {string} text
   * @param {{extras?: string[], step?: string}} [options]  automatic constraints; title of the step
   * @returns {Promise<Reply>}
   */
  async run(text, options = {}) {
    const reply = await this._request({ type: "run", text, ...options });
    if (reply.ok) this.dispatchEvent(new Event("ran"));
    return reply;
  }

  /**
   * What a command would do.
   * @param {string} text
   */
  explain(text) {
    return this._request({ type: "explain", text });
  }

  /**
   * A question: "free", "conflicts", "why", "measure", "complete", "help", "info", "history", "table", "evaluate".
   * @param {string} what
   * @param {object} [args]
   */
  ask(what, args = {}) {
    return this._request({ type: "ask", what, ...args });
  }

  /**
   * Import, export or save a file.
   * @param {{do: "import"|"export"|"save", format?: string, name?: string, data?: string}} order
   */
  file(order) {
    return this._request({ type: "file", ...order });
  }

  /**
   * Answer an agent's question.
   * @param {string} id
   * @param {boolean} allow
   * @param {boolean} [always]
   */
  answer(id, allow, always = false) {
    this.send({ type: "answer", id, allow, ...(always ? { always } : {}) });
  }

  /** Take back an agent's standing permission. @param {string} session */
  revoke(session) {
    this.send({ type: "revoke", session });
  }

  /** Break off the solve that is running. */
  breakOff() {
    this.send({ type: "break" });
  }

  /**
   * Begin a drag of points, curves, or an arc's radius (`A0.radius`).
   * @param {string[]} handles
   * @param {Point} at
   */
  beginDrag(handles, at) {
    this._dragging = true;
    this._place = this._last = null;
    this._answered = this._sequence;
    return this._request({ type: "drag", handles, at });
  }

  /**
   * Drag to a place. At most one is on its way; of those that wait only the newest is kept. A place that
   * comes twice, by both events of one move of the mouse, is sent once.
   * @param {Point} at
   */
  dragTo(at) {
    this._place = this._last && at[0] === this._last[0] && at[1] === this._last[1] ? null : at;
    this._sendPlace();
  }

  /**
   * End the drag, or take it back.
   * @param {boolean} [cancel]
   */
  async drop(cancel = false) {
    const last = this._place;
    this._place = null;
    if (last && !cancel) this._send(encodePointer(last[0], last[1], ++this._sequence));
    this._dragging = false;
    const reply = await this._request({ type: "drop", ...(cancel ? { cancel: true } : {}) });
    this.store.settle();
    if (reply.ok && !cancel) this.dispatchEvent(new Event("ran"));
    return reply;
  }

  /** Milliseconds since the place that is on its way was sent, 0 if none is. */
  get delay() {
    return this._answered < this._sequence ? performance.now() - this._sent : 0;
  }

  /**
   * Send without a reply; nothing happens while the link is lost.
   * @param {object} message
   */
  send(message) {
    this._send(encodeJson(message));
  }

  /** @param {ArrayBuffer} buffer */
  _send(buffer) {
    if (this.state === "open") this._connection?.send(buffer);
  }

  _sendPlace() {
    if (!this._place || !this._dragging || this._answered < this._sequence) return;
    const [x, y] = (this._last = this._place);
    this._place = null;
    this._sent = performance.now();
    this._send(encodePointer(x, y, ++this._sequence));
  }

  /**
   * @param {object} message
   * @returns {Promise<Reply>}
   */
  _request(message) {
    if (this.state !== "open") return Promise.resolve(lost());
    const id = ++this._id;
    return new Promise((resolve) => {
      this._waiting.set(id, resolve);
      this.send({ ...message, id });
    });
  }

  /** @param {ArrayBuffer} buffer */
  _receive(buffer) {
    const message = decode(buffer);
    if (message.kind === NUMBERS_KIND) {
      const answers = message.sequence > this._answered;
      this._answered = Math.max(this._answered, message.sequence);
      const delay = performance.now() - this._sent;
      // the next place is solved while this frame is painted
      this._sendPlace();
      if (message.offsets && message.numbers) this.store.frame(message.offsets, message.numbers, answers);
      this.dispatchEvent(new CustomEvent("frame", { detail: { delay, sequence: message.sequence } }));
    } else if (message.kind === JSON_KIND) {
      this._json(message.json);
    }
  }

  /** @param {any} message */
  _json(message) {
    if (message.type === "reply") {
      this._waiting.get(message.id)?.(message);
      this._waiting.delete(message.id);
    }
    if (!this.store.receive(message)) this.send({ type: "refresh" });
  }

  _lost() {
    this._set("lost");
    this._connection = null;
    this._dragging = false;
    this._answered = this._sequence;
    for (const resolve of this._waiting.values()) resolve(lost());
    this._waiting.clear();
    this.store.settle();
    if (this._closed) return;
    setTimeout(() => this.open(), this._wait);
    this._wait = Math.min(2 * this._wait, LONGEST_WAIT);
  }

  /** @param {"open"|"lost"} state */
  _set(state) {
    if (state === this.state) return;
    this.state = state;
    this.dispatchEvent(new Event("state"));
  }
}

/** @returns {Reply} */
function lost() {
  const message = "the connection to the server is lost; the command was not run";
  const hint = "it connects again by itself; repeat the command then";
  return { ok: false, text: message, error: { code: "", message, hint } };
}

/** @returns {string} */
export function randomId() {
  return Array.from(crypto.getRandomValues(new Uint32Array(2)), (n) => n.toString(36)).join("");
}
