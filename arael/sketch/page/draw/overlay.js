/** What lies over the drawing: hovered things, previews, snaps, automatic constraints, typed values. */

import { curveOf } from "../geometry/curves.js";
import { splitHandle } from "../geometry/handles.js";
import { traceText } from "../geometry/lettering.js";
import { drawDimensions } from "./dimension_marks.js";
import { cutMark, drawSnapMark } from "./marks.js";
import { FONT } from "./palette.js";
import { disc, trace } from "./paths.js";
import { drawBadge } from "./symbols.js";

/**
 * @typedef {import("../types.js").Point} Point
 * @typedef {import("../types.js").Preview} Preview
 * @typedef {import("./palette.js").Palette} Palette
 * @typedef {CanvasRenderingContext2D} Context
 */

/**
 * @param {Context} ctx
 * @param {import("../app.js").App} app
 * @param {Palette} palette
 * @param {{cursor: Point|null, late: number}} state
 */
export function drawOverlay(ctx, app, palette, state) {
  const { view, store, tools } = app;
  const tool = tools.current;
  ctx.clearRect(0, 0, view.width, view.height);
  drawNames(ctx, app, store.hovered, palette.preview);
  const { annotations } = app.renderer;
  annotations.drawGlyphs(ctx, palette, annotations.hoveredGlyphs());
  const preview = tool.preview();
  drawNames(ctx, app, preview.names ?? [], palette.selected);
  drawPreview(ctx, view, preview, palette);
  if (state.cursor) drawCursor(ctx, view.toScreen(state.cursor), palette);
  const { place } = tool;
  // a typed value moves the point away from what it had snapped to
  if (place && place.snap && !tool.picks && !tool.typed.any) drawSnap(ctx, view, place, palette);
  if (place) drawFields(ctx, tool, place.screen, palette);
  for (const { at, text } of preview.labels ?? []) label(ctx, view.toScreen(at), text, palette);
  if (state.late > 0 && place) drawLate(ctx, place.screen, palette);
}

/** @param {Context} ctx @param {import("../app.js").App} app @param {Iterable<string>} names @param {string} colour */
function drawNames(ctx, app, names, colour) {
  const { store, view } = app;
  ctx.strokeStyle = colour;
  ctx.globalAlpha = 0.4;
  ctx.lineWidth = 6;
  ctx.lineCap = "round";
  ctx.beginPath();
  for (const name of names) {
    for (const target of targets(store, name)) {
      const entity = store.entities.get(target);
      const curve = entity && curveOf(entity, store.values);
      if (curve) trace(ctx, curve, view);
      const at = store.point(target);
      if (at) {
        const [x, y] = view.toScreen(at);
        disc(ctx, x, y, 6);
      }
    }
  }
  ctx.stroke();
  ctx.globalAlpha = 1;
  ctx.lineCap = "butt";
}

/** Entities and points that a name stands for. @param {import("../store.js").Store} store @param {string} name */
function targets(store, name) {
  const record = store.constraints.get(name) ?? store.dimensions.get(name);
  if (record) return record.args;
  const group = store.groups.get(name);
  if (group) return [...(group.sources ?? []), ...(group.results ?? [])];
  return store.entities.has(splitHandle(name)[0]) ? [name] : [];
}

/** @param {Context} ctx @param {import("../view.js").View} view @param {Preview} preview @param {Palette} palette */
function drawPreview(ctx, view, preview, palette) {
  ctx.strokeStyle = palette.guide;
  ctx.lineWidth = 1;
  ctx.setLineDash([3, 4]);
  ctx.beginPath();
  for (const curve of preview.guides ?? []) trace(ctx, curve, view);
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.strokeStyle = palette.preview;
  ctx.lineWidth = 1.8;
  ctx.beginPath();
  for (const curve of preview.curves ?? []) trace(ctx, curve, view);
  for (const { text, from, to } of preview.texts ?? []) traceText(ctx, text, view.toScreen(from), view.toScreen(to));
  ctx.stroke();
  ctx.beginPath();
  for (const p of preview.points ?? []) disc(ctx, ...view.toScreen(p), 3);
  ctx.fillStyle = palette.background;
  ctx.fill();
  ctx.stroke();
  drawCuts(ctx, view, preview.cuts ?? [], palette);
  if (preview.dimension) drawDimensions(ctx, [preview.dimension], palette.preview, palette.background);
  if (preview.box) drawBox(ctx, preview.box, palette);
}

/**
 * A bar across the curve at every cut, unlike the mark of any point.
 * @param {Context} ctx
 * @param {import("../view.js").View} view
 * @param {{at: Point, along: Point}[]} cuts
 * @param {Palette} palette
 */
function drawCuts(ctx, view, cuts, palette) {
  ctx.beginPath();
  for (const { at, along } of cuts) cutMark(ctx, ...view.toScreen(at), along);
  ctx.lineWidth = 5.5;
  ctx.strokeStyle = palette.background;
  ctx.stroke();
  ctx.lineWidth = 2.2;
  ctx.strokeStyle = palette.snap;
  ctx.stroke();
}

/** A selection box: from left to right solid, from right to left dashed. @param {Context} ctx @param {{from: Point, to: Point}} box @param {Palette} palette */
function drawBox(ctx, { from, to }, palette) {
  ctx.beginPath();
  ctx.rect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
  ctx.fillStyle = ctx.strokeStyle = to[0] >= from[0] ? palette.preview : palette.selected;
  ctx.globalAlpha = 0.1;
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.lineWidth = 1;
  ctx.setLineDash(to[0] >= from[0] ? [] : [5, 4]);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** @param {Context} ctx @param {import("../view.js").View} view @param {import("../types.js").Place} place @param {Palette} palette */
function drawSnap(ctx, view, place, palette) {
  const { snap } = place;
  if (!snap) return;
  ctx.strokeStyle = palette.guide;
  ctx.lineWidth = 1;
  ctx.setLineDash([3, 4]);
  ctx.beginPath();
  for (const [a, b] of snap.guides ?? []) {
    ctx.moveTo(...view.toScreen(a));
    ctx.lineTo(...view.toScreen(b));
  }
  ctx.stroke();
  ctx.setLineDash([]);
  const [x, y] = view.toScreen(place.at);
  drawSnapMark(ctx, snap.kind, x, y, palette);
  if (place.bare) return;
  // automatic constraints: what a click would add
  const kinds = snap.extras.map((extra) => extra.split(" ")[0]);
  kinds.forEach((kind, i) => {
    drawBadge(ctx, kind, x + 20 + 19 * i, y - 18, {
      half: 8, back: palette["glyph-back"], edge: palette.snap, ink: palette.snap, width: 1.2,
    });
  });
}

/** @param {Context} ctx @param {import("../tools/tool.js").Tool} tool @param {Point} at @param {Palette} palette */
function drawFields(ctx, tool, at, palette) {
  const fields = tool.fields();
  if (!fields.length) return;
  ctx.font = `12px ${FONT}`;
  ctx.textBaseline = "middle";
  ctx.textAlign = "left";
  let y = at[1] + 26;
  const { typed, app: { store: { lengths } } } = tool;
  fields.forEach((field, i) => {
    const active = typed.open && i === Math.min(typed.active, fields.length - 1);
    const value = field.text || (field.quantity === "count" ? String(field.value) : rounded(field.quantity === "length" ? lengths.number(field.value, "length") : field.value));
    const unit = field.quantity === "angle" ? "°" : field.quantity === "length" && lengths.other ? ` ${lengths.name}` : "";
    const suffix = field.text ? "" : unit;
    const text = `${field.title} ${value}${suffix}${active ? "▏" : ""}`;
    const width = ctx.measureText(text).width + 12;
    ctx.beginPath();
    ctx.roundRect(at[0] + 16, y - 9, width, 18, 4);
    ctx.fillStyle = field.text ? palette.preview : palette["label-back"];
    ctx.globalAlpha = field.text || active ? 1 : 0.78;
    ctx.fill();
    if (active) {
      ctx.strokeStyle = palette.snap;
      ctx.lineWidth = 1.5;
      ctx.stroke();
    }
    ctx.fillStyle = palette.label;
    ctx.fillText(text, at[0] + 22, y + 0.5);
    ctx.globalAlpha = 1;
    y += 21;
  });
}

/** @param {number} value */
const rounded = (value) => String(Number(value.toPrecision(4))).replace("-", "−");

/** Lines of text above a place. @param {Context} ctx @param {Point} at @param {string} text @param {Palette} palette */
function label(ctx, at, text, palette) {
  const lines = text.split("\n");
  const height = 15 * lines.length + 4;
  ctx.font = `12px ${FONT}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  const width = Math.max(...lines.map((line) => ctx.measureText(line).width)) + 14;
  ctx.beginPath();
  ctx.roundRect(at[0] - width / 2, at[1] - 6 - height, width, height, 4);
  ctx.fillStyle = palette["label-back"];
  ctx.fill();
  ctx.fillStyle = palette.label;
  lines.forEach((line, i) => ctx.fillText(line, at[0], at[1] + 4 - height + 15 * i));
}

/** The cursor of the commands: where `@dx,dy` starts. @param {Context} ctx @param {Point} at @param {Palette} palette */
function drawCursor(ctx, [x, y], palette) {
  ctx.strokeStyle = palette.guide;
  ctx.lineWidth = 1.2;
  ctx.beginPath();
  ctx.moveTo(x - 8, y);
  ctx.lineTo(x + 8, y);
  ctx.moveTo(x, y - 8);
  ctx.lineTo(x, y + 8);
  ctx.stroke();
}

/** A frame of the drag is late. @param {Context} ctx @param {Point} at @param {Palette} palette */
function drawLate(ctx, [x, y], palette) {
  ctx.fillStyle = palette.snap;
  ctx.beginPath();
  for (const i of [0, 1, 2]) disc(ctx, x + 14 + 7 * i, y + 16, 2);
  ctx.fill();
}
