/** Entities sorted by how they look, so that each look is one stroke of the canvas. */

import { boundsOf, curveOf } from "../geometry/curves.js";
import { pointHandles, pointOffset, splitHandle } from "../geometry/handles.js";
import { traceLettering } from "./lettering.js";
import { CONSTRUCTION_DASH, STATES, STYLE_DASHES } from "./palette.js";
import { markPen, trace } from "./paths.js";
import { stampMarks } from "./stamps.js";

/**
 * @typedef {import("../types.js").Entity} Entity
 * @typedef {{state: string, construction: boolean, style: string, lines: number[], curves: Entity[], texts: Entity[]}} Batch
 * @typedef {{state: string, large: boolean, offsets: number[], places: Float64Array}} Marks
 * @typedef {import("../store.js").Store} Store
 * @typedef {import("../view.js").View} View
 * @typedef {import("./palette.js").Palette} Palette
 * @typedef {import("./sheet.js").Sheet} Sheet
 * @typedef {import("./swept.js").Swept} Swept
 */

const RANK = ["defined", "free", "redundant", "impossible", "selected"];
/** Segments in one path: the rasteriser's cost grows faster than their number. */
const CHUNK = 128;
/** Curves shorter than this on the screen, in pixels, have no marks at their points. */
const MARKED = 14;
/** How far curves may be drawn beside their bounds, in pixels: where they turn, their stroke has a tip. */
const TIP = 50;

const NOWHERE = new Float64Array(0);

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
    for (const one of this.marks) one.places = new Float64Array(4 * one.offsets.length);
    /** Ends of lines that are drawn by hand. */
    this._ends = new Float64Array(4 * Math.max(0, ...this.batches.map((one) => one.lines.length)));
    this.meanLength = counted ? total / counted : Infinity;
    // whether all of it can be drawn by hand
    this.isPlain = this.batches.every((one) => isSolid(one) && !one.curves.length && !one.texts.length);
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
        found = { state, large, offsets: [], places: NOWHERE };
        marks.set(key, found);
      }
      found.offsets.push(pointOffset(entity, splitHandle(handle)[1]));
    }
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {View} view
   * @param {Palette} palette
   * @param {Swept} [swept]  is given what is drawn where
   */
  draw(ctx, view, palette, swept) {
    for (const batch of this.batches) this._halo(ctx, view, palette, batch);
    for (const batch of this.batches) this._outline(ctx, view, palette, batch, swept);
    for (const marks of this.marks) {
      const count = this._placeMarks(marks, view, swept);
      const pen = markPen(ctx, lookOf(marks, palette));
      for (let i = 0; i < 4 * count; i += 4) pen(marks.places[i], marks.places[i + 1]);
    }
  }

  /**
   * Draw solid lines and marks by hand.
   * @param {Sheet} sheet @param {View} view @param {Palette} palette
   * @param {Swept} swept  is given what is drawn where
   */
  drawByHand(sheet, view, palette, swept) {
    const v = this.store.values;
    const { x, y, scale: s } = view;
    for (const { state, lines } of this.batches.filter(isSolid)) {
      const count = lines.length;
      const ends = this._ends;
      for (let i = 0; i < count; i++) {
        const at = lines[i];
        for (let k = 0; k < 4; k += 2) {
          ends[4 * i + k] = x + s * v[at + k];
          ends[4 * i + k + 1] = y - s * v[at + k + 1];
        }
      }
      sheet.lines(ends, count, STATES[state].width, sheet.colour(colour(palette, state)));
      swept.addEach(ends, count);
    }
    for (const marks of this.marks) stampMarks(sheet, lookOf(marks, palette), marks.places, this._placeMarks(marks, view, swept));
  }

  /** Draw the rest below what was drawn by hand. @param {CanvasRenderingContext2D} ctx @param {View} view @param {Palette} palette @param {Swept} swept */
  drawBelow(ctx, view, palette, swept) {
    if (this.isPlain) return;
    // what would be drawn last is drawn first
    const rest = [...this.batches].reverse();
    ctx.globalCompositeOperation = "destination-over";
    for (const one of rest) this._outline(ctx, view, palette, one, swept, isSolid(one));
    for (const one of rest) this._halo(ctx, view, palette, one);
    ctx.globalCompositeOperation = "source-over";
  }

  /** How many pixels are filled by hand, about. @param {View} view @param {number} ratio */
  byHand(view, ratio) {
    const v = this.store.values;
    let sum = 0;
    for (const batch of this.batches) {
      for (const at of batch.lines) sum += Math.abs(v[at + 2] - v[at]) + Math.abs(v[at + 3] - v[at + 1]);
    }
    return sum * view.scale * ratio * (2 * ratio + 1);
  }

  /**
   * The strokes of a batch, without its halo.
   * @param {CanvasRenderingContext2D} ctx @param {View} view @param {Palette} palette @param {Batch} batch
   * @param {Swept} [swept]
   * @param {boolean} [curved]  without its lines
   */
  _outline(ctx, view, palette, batch, swept, curved) {
    const { state, construction } = batch;
    const look = STATES[state] ?? STATES.defined;
    const dash = STYLE_DASHES[batch.style] ?? [];
    ctx.strokeStyle = colour(palette, construction && state === "defined" ? "construction" : state);
    ctx.lineWidth = construction ? 1.1 : look.width;
    ctx.setLineDash(dash.length ? dash : construction ? CONSTRUCTION_DASH : []);
    // halos are drawn before, over the same places
    this._stroke(ctx, view, batch, swept, curved);
    ctx.setLineDash([]);
    this._letter(ctx, view, batch, swept);
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

  /** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Batch} batch @param {Swept} [swept] @param {boolean} [curved] */
  _stroke(ctx, view, batch, swept, curved) {
    const v = this.store.values;
    const { scale: s, x, y, width, height } = view;
    const lines = curved ? [] : batch.lines;
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
      swept?.add(x1, y1, x2, y2);
      if (++count % CHUNK === 0) {
        ctx.stroke();
        ctx.beginPath();
      }
    }
    for (const entity of batch.curves) {
      const curve = curveOf(entity, v);
      if (curve) {
        trace(ctx, curve, view);
        const b = boundsOf(curve);
        swept?.add(x + s * b.xmin, y - s * b.ymin, x + s * b.xmax, y - s * b.ymax, TIP);
      }
      if (++count % CHUNK === 0) {
        ctx.stroke();
        ctx.beginPath();
      }
    }
    ctx.stroke();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Batch} batch @param {Swept} [swept] */
  _letter(ctx, view, batch, swept) {
    if (!batch.texts.length) return;
    swept?.addAll();
    ctx.beginPath();
    for (const frame of batch.texts) traceLettering(ctx, view, frame, this.store.values);
    ctx.stroke();
  }

  /**
   * Fill in where marks are: x, y, x, y, twice the same; returns how many there are to be drawn.
   * @param {Marks} marks @param {View} view @param {Swept} [swept]
   */
  _placeMarks({ state, large, offsets, places }, view, swept) {
    const v = this.store.values;
    const { x, y, scale: s, width, height } = view;
    const crowded = this.meanLength * s < MARKED;
    if (!large && crowded && (state === "free" || state === "defined")) return 0;
    let count = 0;
    // ends that coincide have one mark
    const seen = new Set();
    for (let i = 0; i < offsets.length; i++) {
      const px = x + s * v[offsets[i]];
      const py = y - s * v[offsets[i] + 1];
      if (px < -9 || py < -9 || px > width + 9 || py > height + 9) continue;
      const key = Math.round(4 * px) * 0x8000 + Math.round(4 * py);
      if (seen.has(key)) continue;
      seen.add(key);
      places[4 * count] = places[4 * count + 2] = px;
      places[4 * count + 1] = places[4 * count + 3] = py;
      count++;
    }
    swept?.addEach(places, count);
    return count;
  }
}

/** @param {Marks} marks @param {Palette} palette @returns {import("./paths.js").Look} */
function lookOf({ state, large }, palette) {
  const { end } = STATES[state] ?? STATES.defined;
  return { shape: end, r: large ? 3.4 : 2.7, colour: colour(palette, state), back: palette.background };
}

/** Whether lines of a batch are neither dashed nor have a halo. @param {Batch} batch */
const isSolid = ({ state, construction, style }) => !construction && style === "solid" && STATES[state]?.halo === 0;

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

/** Construction lies behind the outline, what matters most in front. @param {Batch} a @param {Batch} b */
function order(a, b) {
  return Number(b.construction) - Number(a.construction) || RANK.indexOf(a.state) - RANK.indexOf(b.state);
}

/** @param {Palette} palette @param {string} name */
const colour = (palette, name) => /** @type {Record<string, string>} */ (palette)[name] ?? palette.defined;
