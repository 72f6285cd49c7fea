/** The page's copy of the document, kept up to date by the server's messages. */

import { pointOffset, splitHandle } from "./geometry/handles.js";
import { Lengths } from "./lengths.js";

/**
 * @typedef {import("./types.js").Entity} Entity
 * @typedef {import("./types.js").Tables} Tables
 * @typedef {import("./types.js").Point} Point
 * @typedef {import("./types.js").Verdict} Verdict
 * @typedef {{put: Tables, removed: Record<string, string[]>, all: boolean}} ChangeDetail
 */

const TABLES = /** @type {const} */ (["entities", "constraints", "dimensions", "parameters", "groups"]);

/**
 * Events: "change" (records), "values" (numbers only), "verdict", "selection", "hover", "history",
 * "status" (hello, saved, presence, unjudged, busy, idle, agent, permissions, view: `detail` is the message), "message", "reply".
 */
export class Store extends EventTarget {
  /** @type {Map<string, Entity>} */
  entities = new Map();
  /** @type {Map<string, import("./types.js").Constraint>} */
  constraints = new Map();
  /** @type {Map<string, import("./types.js").Dimension>} */
  dimensions = new Map();
  /** @type {Map<string, import("./types.js").Parameter>} */
  parameters = new Map();
  /** @type {Map<string, import("./types.js").Group>} */
  groups = new Map();
  /** Numbers as they are shown: those of the document, or of the drag that is under way. */
  values = new Float64Array(0);
  /** Numbers of the document. */
  _settled = new Float64Array(0);
  /** @type {Verdict} */
  verdict = { revision: 0, freedoms: 0, entities: {}, constraints: {}, points: {} };
  history = { done: /** @type {string[]} */ ([]), undone: /** @type {string[]} */ ([]) };
  revision = 0;
  /** The revision of which there is no verdict, since that was broken off. */
  unjudged = 0;
  unit = "mm";
  /** The unit in which lengths are shown and typed. */
  lengths = new Lengths(this);
  file = "";
  /** @type {Record<string, unknown>} */
  settings = {};
  /** Names and handles. @type {Set<string>} */
  selection = new Set();
  /** Names that a panel or the pointer highlights. @type {Set<string>} */
  hovered = new Set();
  /** Whether numbers of a drag are shown. */
  dragging = false;

  /**
   * Coordinates of a point by its handle (`L0.p1`, `P0`).
   * @param {string} handle
   * @returns {Point|null}
   */
  point(handle) {
    const offset = this.offset(handle);
    return offset < 0 ? null : [this.values[offset], this.values[offset + 1]];
  }

  /**
   * Offset of a point's x, -1 if there is no such point.
   * @param {string} handle
   */
  offset(handle) {
    const [name, point] = splitHandle(handle);
    const entity = this.entities.get(name);
    return entity ? pointOffset(entity, point) : -1;
  }

  /** Numbers of an entity. @param {string} name */
  numbers(name) {
    const entity = this.entities.get(name);
    return entity ? this.values.subarray(entity.at, entity.at + entity.size) : new Float64Array(0);
  }

  /**
   * Replace the selection, or add to it.
   * @param {Iterable<string>} names
   * @param {"replace"|"add"|"remove"|"toggle"} [how]
   */
  select(names, how = "replace") {
    if (how === "replace") this.selection = new Set(names);
    else {
      for (const name of names) {
        const drop = how === "remove" || (how === "toggle" && this.selection.has(name));
        if (drop) this.selection.delete(name);
        else this.selection.add(name);
      }
    }
    this._emit("selection");
  }

  /**
   * Highlight names in the drawing.
   * @param {Iterable<string>} names
   */
  hover(names) {
    const next = new Set(names);
    if (next.size === this.hovered.size && [...next].every((name) => this.hovered.has(name))) return;
    this.hovered = next;
    this._emit("hover");
  }

  /**
   * Show numbers of a drag: a view only.
   * @param {Uint32Array} offsets
   * @param {Float64Array} numbers
   * @param {boolean} [answers]  whether it answers the newest place of this window's pointer
   */
  frame(offsets, numbers, answers = false) {
    const values = this.values;
    for (let i = 0; i < offsets.length; i++) values[offsets[i]] = numbers[i];
    this.dragging = true;
    this._emit("values", { offsets, answers });
  }

  /** Show the document's own numbers again, after a drag. */
  settle() {
    if (!this.dragging) return;
    this.dragging = false;
    this.values.set(this._settled);
    this._emit("values", { offsets: null, answers: false });
  }

  /**
   * Take a message of the server.
   * @param {any} message
   * @returns {boolean} false if a change does not follow on what is here: a snapshot is needed
   */
  receive(message) {
    switch (message.type) {
      case "snapshot":
        this._snapshot(message);
        return true;
      case "change":
        if (message.from !== this.revision) return message.revision <= this.revision;
        this._change(message);
        return true;
      case "verdict":
        this._verdict(message);
        return true;
      case "history":
        this.history = { done: message.done, undone: message.undone };
        this._emit("history");
        return true;
      case "message":
      case "reply":
        this._emit(message.type, message);
        return true;
      default:
        if (message.type === "unjudged") {
          this.unjudged = message.revision;
          this._emit("verdict");
        }
        if (message.type === "hello") {
          this.unit = message.unit ?? this.unit;
          this.file = message.file ?? "";
        }
        this._emit("status", message);
        return true;
    }
  }

  /** @param {any} message */
  _snapshot(message) {
    for (const table of TABLES) {
      const records = /** @type {Map<string, any>} */ (this[table]);
      records.clear();
      for (const record of message.document[table] ?? []) records.set(record.name, record);
    }
    this._settled = Float64Array.from(message.values);
    this.values = this._settled.slice();
    this.dragging = false;
    this.revision = message.revision;
    this._settings(message);
    this._prune();
    this._emit("change", { put: {}, removed: {}, all: true });
  }

  /** @param {any} message */
  _change(message) {
    for (const table of TABLES) {
      const records = /** @type {Map<string, any>} */ (this[table]);
      for (const name of message.removed?.[table] ?? []) records.delete(name);
      for (const record of message.put?.[table] ?? []) records.set(record.name, record);
      const order = message.order?.[table];
      if (order) reorder(records, order);
    }
    this._numbers(message);
    this.revision = message.revision;
    this._settings(message);
    const removed = message.removed ?? {};
    if (TABLES.some((table) => removed[table]?.length)) this._prune();
    this._emit("change", { put: message.put ?? {}, removed, all: false });
  }

  /** @param {any} message */
  _numbers(message) {
    const offsets = message.offsets ?? [];
    const numbers = message.numbers ?? [];
    let size = this._settled.length;
    for (const entity of message.put?.entities ?? []) size = Math.max(size, entity.at + entity.size);
    for (const offset of offsets) size = Math.max(size, offset + 1);
    if (size > this._settled.length) {
      // room to grow, so that a long chain of new entities copies seldom
      const grown = new Float64Array(Math.ceil(size * 1.25));
      grown.set(this._settled);
      this._settled = grown;
      this.values = grown.slice();
    }
    for (let i = 0; i < offsets.length; i++) this._settled[offsets[i]] = numbers[i];
    if (this.dragging) {
      this.dragging = false;
      this.values.set(this._settled);
    } else for (let i = 0; i < offsets.length; i++) this.values[offsets[i]] = numbers[i];
  }

  /** @param {any} message */
  _verdict(message) {
    const full = message.full ?? true;
    const before = this.verdict;
    this.verdict = {
      revision: message.revision,
      freedoms: message.freedoms,
      entities: full ? message.entities ?? {} : { ...before.entities, ...message.entities },
      constraints: full ? message.constraints ?? {} : merged(before.constraints, message.constraints),
      points: full ? message.points ?? {} : { ...before.points, ...message.points },
    };
    this._emit("verdict");
  }

  /** @param {any} message */
  _settings(message) {
    const settings = message.type === "change" ? { ...this.settings, ...message.settings } : message.settings;
    if (settings) this.settings = settings;
    const unit = message.unit ?? message.settings?.unit;
    if (typeof unit === "string") this.unit = unit;
  }

  /** Whether the verdict is one on what is shown. */
  get isJudged() {
    return this.verdict.revision === this.revision;
  }

  /** Take out of the selection what is no longer there. */
  _prune() {
    const gone = [...this.selection].filter((name) => !this.has(name));
    if (gone.length) this.select(gone, "remove");
  }

  /**
   * Whether there is a record or point of this name.
   * @param {string} name
   */
  has(name) {
    return (
      this.entities.has(name) ||
      this.constraints.has(name) ||
      this.dimensions.has(name) ||
      this.groups.has(name) ||
      this.offset(name) >= 0
    );
  }

  /**
   * @param {string} type
   * @param {any} [detail]
   */
  _emit(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}

/**
 * @param {Map<string, any>} records
 * @param {string[]} order
 */
function reorder(records, order) {
  const all = order.map((name) => [name, records.get(name)]);
  records.clear();
  for (const [name, record] of all) if (record) records.set(name, record);
}

/**
 * A difference of verdicts: what is null or empty is no longer marked.
 * @param {Record<string, string>} before
 * @param {Record<string, string|null>|undefined} changes
 */
function merged(before, changes) {
  const found = { ...before };
  for (const [name, state] of Object.entries(changes ?? {})) {
    if (state) found[name] = state;
    else delete found[name];
  }
  return found;
}
