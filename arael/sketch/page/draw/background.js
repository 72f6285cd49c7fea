/** Grid, axes and scale bar. */

import { FONT } from "./palette.js";
import { numberText } from "./texts.js";

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("../view.js").View} view
 * @param {import("./palette.js").Palette} palette
 */
export function drawGrid(ctx, view, palette) {
  if (view.grid) {
    const step = view.gridStep();
    lines(ctx, view, step, palette.grid);
    lines(ctx, view, 5 * step, palette["grid-strong"]);
  }
  const [x, y] = [Math.round(view.x) + 0.5, Math.round(view.y) + 0.5];
  ctx.lineWidth = 1;
  ctx.strokeStyle = palette["axis-x"];
  ctx.beginPath();
  ctx.moveTo(0, y);
  ctx.lineTo(view.width, y);
  ctx.stroke();
  ctx.strokeStyle = palette["axis-y"];
  ctx.beginPath();
  ctx.moveTo(x, 0);
  ctx.lineTo(x, view.height);
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {import("../view.js").View} view @param {number} step @param {string} colour */
function lines(ctx, view, step, colour) {
  const box = view.visible;
  ctx.beginPath();
  for (let i = Math.ceil(box.xmin / step); i * step <= box.xmax; i++) {
    const x = Math.round(view.x + view.scale * i * step) + 0.5;
    ctx.moveTo(x, 0);
    ctx.lineTo(x, view.height);
  }
  for (let i = Math.ceil(box.ymin / step); i * step <= box.ymax; i++) {
    const y = Math.round(view.y - view.scale * i * step) + 0.5;
    ctx.moveTo(0, y);
    ctx.lineTo(view.width, y);
  }
  ctx.lineWidth = 1;
  ctx.strokeStyle = colour;
  ctx.stroke();
}

/**
 * A round length in the lower left corner.
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("../view.js").View} view
 * @param {import("./palette.js").Palette} palette
 * @param {import("../lengths.js").Lengths} lengths
 */
export function drawScaleBar(ctx, view, palette, lengths) {
  if (view.width < 260) return;
  const length = view.gridStep(60);
  // On a narrow drawing it stands above the command field.
  const [x, y, w] = [16.5, view.height - (view.width < 900 ? 64.5 : 16.5), length * view.scale];
  ctx.strokeStyle = ctx.fillStyle = palette.note;
  ctx.lineWidth = 1.2;
  ctx.beginPath();
  ctx.moveTo(x, y - 4);
  ctx.lineTo(x, y);
  ctx.lineTo(x + w, y);
  ctx.lineTo(x + w, y - 4);
  ctx.stroke();
  ctx.font = `11px ${FONT}`;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  ctx.fillText(`${numberText(lengths.number(length, "length"))} ${lengths.name}`, x + w + 8, y - 2);
}
