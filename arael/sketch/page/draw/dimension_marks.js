/** Dimensions on the canvas: lines, arrows, texts. */

import { ARROW } from "./lines.js";
import { FONT } from "./palette.js";

export const TEXT = `12px ${FONT}`;

/** @typedef {import("./lines.js").Drawn} Drawn */

/**
 * Draws dimensions of one colour: each kind of line of all of them in one stroke.
 * @param {CanvasRenderingContext2D} ctx @param {Drawn[]} all @param {string} colour @param {string} back
 * @param {number[]} [dash]  of their lines
 */
export function drawDimensions(ctx, all, colour, back, dash = []) {
  ctx.strokeStyle = ctx.fillStyle = colour;
  ctx.lineWidth = 0.8;
  ctx.globalAlpha = 0.6;
  ctx.beginPath();
  for (const { thin } of all) segments(ctx, thin);
  ctx.stroke();
  ctx.globalAlpha = 1;
  ctx.lineWidth = dash.length ? 1.6 : 1;
  ctx.setLineDash(dash);
  ctx.beginPath();
  for (const { lines, arcs } of all) {
    segments(ctx, lines);
    for (const [x, y, r, start, sweep] of arcs) {
      ctx.moveTo(x + r * Math.cos(start), y + r * Math.sin(start));
      ctx.arc(x, y, r, start, start + sweep, sweep < 0);
    }
  }
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.beginPath();
  for (const { arrows } of all) {
    for (let k = 0; k < arrows.length; k += 4) {
      const ux = ARROW * arrows[k + 2];
      const uy = ARROW * arrows[k + 3];
      const x = arrows[k] - ux;
      const y = arrows[k + 1] - uy;
      ctx.moveTo(arrows[k], arrows[k + 1]);
      ctx.lineTo(x - 0.28 * uy, y + 0.28 * ux);
      ctx.lineTo(x + 0.28 * uy, y - 0.28 * ux);
      ctx.closePath();
    }
  }
  ctx.fill();
  ctx.save();
  ctx.font = TEXT;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  // the background's colour around the digits keeps them readable where a line passes
  ctx.lineWidth = 3;
  ctx.lineJoin = "round";
  ctx.strokeStyle = back;
  for (const { text: { x, y, angle, text } } of all) {
    ctx.translate(x, y);
    ctx.rotate(angle);
    ctx.strokeText(text, 0, 0.5);
    ctx.fillText(text, 0, 0.5);
    ctx.rotate(-angle);
    ctx.translate(-x, -y);
  }
  ctx.restore();
}

/** @param {CanvasRenderingContext2D} ctx @param {number[]} lines */
function segments(ctx, lines) {
  for (let k = 0; k < lines.length; k += 4) {
    ctx.moveTo(lines[k], lines[k + 1]);
    ctx.lineTo(lines[k + 2], lines[k + 3]);
  }
}
