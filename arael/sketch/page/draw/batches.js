/** Entities sorted by how they look, so that each look is one stroke of the canvas. */

import { curveOf } from "../geometry/curves.js";
import { pointHandles, pointOffset, splitHandle } from "../geometry/handles.js";
import { traceLettering } from "./lettering.js";
import { CONSTRUCTION_DASH, STATES, STYLE_DASHES } from "./palette.js";
import { markPen, trace } from "./paths.js";

/**
 * @typedef {import("../types.js").Entity} Entity
 * @typedef {{state: string, construction: boolean, style: string, lines: number[], curves: Entity[], texts: Entity[]}} Batch
 * @typedef {{state: string, large: boolean, offsets: number[]}} Marks
 * @typedef {import("../store.js").Store} Store
 * @typedef {import("../view.js").View} View
 * @typedef {import("./palette.js").Palette} Palette
 */

const RANK = ["defined", "free", "redundant", "impossible", "selected"];
/** Segments in one path: the rasteriser's cost grows faster than their number. */
const CHUNK = 128;
/** Curves shorter than this on the screen, in pixels, have no marks at their points. */
const MARKED = 14;

export class Batches {
  /**
   * @param {Store} store
   * @param {(entity: Entity) => boolean} belongs
   * @param {Record<string, boolean>} [shown]  false for `points` or `construction` leaves them out
   */
  constructor(store, belongs, shown = {}) {
    this.store = store;
    /** @type {Map<string, Batch>} */
    const batches = new Map();
    /** @type {Map<string, Marks>} */
    const marks = new Map();
    /** Selected splines, whose control polygons are shown. @type {Entity[]} */
    this.polygons = [];
    let total = 0;
    let counted = 0;
    for (const entity of store.entities.values()) {
      if (!belongs(entity)) continue;
      if (entity.construction && shown.construction === false) continue;
      const state = stateOf(store, entity.name);
      if (entity.kind !== "point") {
        // the base line of a text is thin and dashed, of a quiet one it is shown where its state is marked
        const base = !!entity.text;
        const hidden = base && ((entity.quiet && !STATES[state]?.halo) || shown.construction === false);
        if (base) batchOf(batches, state, !!entity.construction, "solid").texts.push(entity);
        const batch = hidden ? null : batchOf(batches, state, base || !!entity.construction, entity.style ?? "solid");
        if (entity.kind === "line") batch?.lines.push(entity.at);
        else batch?.curves.push(entity);
        if (hasPoles(entity) && isPicked(store, entity)) this.polygons.push(entity);
      }
      if (entity.kind === "line" && counted < 2000) {
        const v = store.values;
        total += Math.hypot(v[entity.at + 2] - v[entity.at], v[entity.at + 3] - v[entity.at + 1]);
        counted++;
      }
      if (shown.points !== false || entity.kind === "point") this._enterMarks(marks, entity);
    }
    this.batches = [...batches.values()].sort(order);
    this.marks = [...marks.values()].sort((a, b) => RANK.indexOf(a.state) - RANK.indexOf(b.state));
    this.meanLength = counted ? total / counted : Infinity;
  }

  /** @param {Map<string, Marks>} marks @param {Entity} entity */
  _enterMarks(marks, entity) {
    const large = entity.kind === "point";
    if (entity.quiet && !large) return;
    for (const handle of pointHandles(entity)) {
      const state = stateOf(this.store, handle);
      const key = `${state} ${large}`;
      let found = marks.get(key);
      if (!found) {
        found = { state, large, offsets: [] };
        marks.set(key, found);
      }
      found.offsets.push(pointOffset(entity, splitHandle(handle)[1]));
    }
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {View} view
   * @param {Palette} palette
   */
  draw(ctx, view, palette) {
    for (const batch of this.batches) this._halo(ctx, view, palette, batch);
    for (const batch of this.batches) this._outline(ctx, view, palette, batch);
    this._polygons(ctx, view, palette);
    for (const marks of this.marks) this._mark(ctx, view, palette, marks);
  }

  /** The strokes of a batch, without its halo. @param {CanvasRenderingContext2D} ctx @param {View} view @param {Palette} palette @param {Batch} batch */
  _outline(ctx, view, palette, batch) {
    const { state, construction } = batch;
    const look = STATES[state] ?? STATES.defined;
    const dash = STYLE_DASHES[batch.style] ?? [];
    ctx.strokeStyle = colour(palette, construction && state === "defined" ? "construction" : state);
    ctx.lineWidth = construction ? 1.1 : look.width;
    ctx.setLineDash(dash.length ? dash : construction ? CONSTRUCTION_DASH : []);
    // halos are drawn before, over the same places
    this._stroke(ctx, view, batch);
    ctx.setLineDash([]);
    this._letter(ctx, view, batch);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Palette} palette @param {Batch} batch */
  _halo(ctx, view, palette, batch) {
    const look = STATES[batch.state];
    if (!look?.halo) return;
    ctx.strokeStyle = colour(palette, `halo-${batch.state}`);
    ctx.lineWidth = look.halo;
    ctx.setLineDash(look.dash);
    ctx.globalAlpha = 0.55;
    this._stroke(ctx, view, batch);
    ctx.globalAlpha = 1;
    ctx.setLineDash([]);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Batch} batch */
  _stroke(ctx, view, batch) {
    const v = this.store.values;
    const { scale: s, x, y, width, height } = view;
    const { lines } = batch;
    let count = 0;
    ctx.beginPath();
    for (let i = 0; i < lines.length; i++) {
      const at = lines[i];
      const x1 = x + s * v[at];
      const y1 = y - s * v[at + 1];
      const x2 = x + s * v[at + 2];
      const y2 = y - s * v[at + 3];
      if ((x1 < 0 && x2 < 0) || (y1 < 0 && y2 < 0) || (x1 > width && x2 > width) || (y1 > height && y2 > height)) continue;
      ctx.moveTo(x1, y1);
      ctx.lineTo(x2, y2);
      if (++count % CHUNK === 0) {
        ctx.stroke();
        ctx.beginPath();
      }
    }
    for (const entity of batch.curves) {
      const curve = curveOf(entity, v);
      if (curve) trace(ctx, curve, view);
      if (++count % CHUNK === 0) {
        ctx.stroke();
        ctx.beginPath();
      }
    }
    ctx.stroke();
  }

  /** From pole to pole of the selected splines. @param {CanvasRenderingContext2D} ctx @param {View} view @param {Palette} palette */
  _polygons(ctx, view, palette) {
    if (!this.polygons.length) return;
    const v = this.store.values;
    ctx.strokeStyle = palette.guide;
    ctx.lineWidth = 1;
    ctx.setLineDash(CONSTRUCTION_DASH);
    ctx.beginPath();
    for (const { at, size } of this.polygons) {
      ctx.moveTo(...view.toScreen([v[at], v[at + 1]]));
      for (let i = at + 2; i < at + size; i += 2) ctx.lineTo(...view.toScreen([v[i], v[i + 1]]));
    }
    ctx.stroke();
    ctx.setLineDash([]);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Batch} batch */
  _letter(ctx, view, batch) {
    if (!batch.texts.length) return;
    ctx.beginPath();
    for (const frame of batch.texts) traceLettering(ctx, view, frame, this.store.values);
    ctx.stroke();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Palette} palette @param {Marks} marks */
  _mark(ctx, view, palette, marks) {
    const v = this.store.values;
    const { x, y, scale: s, width, height } = view;
    const { state, large, offsets } = marks;
    const crowded = this.meanLength * s < MARKED;
    if (!large && crowded && (state === "free" || state === "defined")) return;
    const pen = markPen(ctx, lookOf(marks, palette));
    // ends that coincide have one mark
    const seen = new Set();
    for (const offset of offsets) {
      const px = x + s * v[offset];
      const py = y - s * v[offset + 1];
      if (px < -9 || py < -9 || px > width + 9 || py > height + 9) continue;
      const key = Math.round(4 * px) * 0x8000 + Math.round(4 * py);
      if (seen.has(key)) continue;
      seen.add(key);
      pen(px, py);
    }
  }
}

/** @param {Marks} marks @param {Palette} palette @returns {import("./paths.js").Look} */
function lookOf({ state, large }, palette) {
  const { end } = STATES[state] ?? STATES.defined;
  return { shape: end, r: large ? 3.4 : 2.7, colour: colour(palette, state), back: palette.background };
}

/** The batch of a look, made if there is none. @param {Map<string, Batch>} batches @param {string} state @param {boolean} construction @param {string} style @returns {Batch} */
function batchOf(batches, state, construction, style) {
  const key = `${state} ${construction ? 1 : 0} ${style}`;
  let batch = batches.get(key);
  if (!batch) {
    batch = { state, construction, style, lines: [], curves: [], texts: [] };
    batches.set(key, batch);
  }
  return batch;
}

/**
 * How an entity or point is shown: conflicts before the selection, the selection before freedom.
 * @param {Store} store
 * @param {string} handle
 */
function stateOf(store, handle) {
  const [name] = splitHandle(handle);
  const { verdict, selection } = store;
  const state = verdict.points[handle] ?? verdict.entities[name] ?? "free";
  if (state === "impossible" || state === "redundant") return state;
  if (selection.has(handle) || selection.has(name)) return "selected";
  return state;
}

/** @param {Entity} entity */
const hasPoles = ({ kind }) => kind === "bezier" || kind === "bspline";

/** Whether an entity or a point of it is selected. @param {Store} store @param {Entity} entity */
function isPicked({ selection }, entity) {
  if (!selection.size) return false;
  return selection.has(entity.name) || pointHandles(entity).some((handle) => selection.has(handle));
}

/** Construction lies behind the outline, what matters most in front. @param {Batch} a @param {Batch} b */
function order(a, b) {
  return Number(b.construction) - Number(a.construction) || RANK.indexOf(a.state) - RANK.indexOf(b.state);
}

/** @param {Palette} palette @param {string} name */
const colour = (palette, name) => /** @type {Record<string, string>} */ (palette)[name] ?? palette.defined;
