/** Dimensions on the canvas: lines, arrows, texts. */

import { FONT } from "./palette.js";

/** Half the width of an arrow, for a length of 1. */
const SLOPE = 0.28;
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
      const x = arrows[k + 2];
      const y = arrows[k + 3];
      const ux = SLOPE * (arrows[k] - x);
      const uy = SLOPE * (arrows[k + 1] - y);
      ctx.moveTo(arrows[k], arrows[k + 1]);
      ctx.lineTo(x - uy, y + ux);
      ctx.lineTo(x + uy, y - ux);
      ctx.closePath();
    }
  }
  ctx.fill();
  ctx.save();
  const write = writer(ctx, colour, back);
  // at whole pixels: digits are sharp
  for (const { text: { x, y, angle, text } } of all) write(text, Math.round(x), Math.round(y), angle);
  ctx.restore();
}

/**
 * Writes texts of dimensions around a place.
 * @param {CanvasRenderingContext2D} ctx @param {string} colour @param {string} back
 */
function writer(ctx, colour, back) {
  ctx.font = TEXT;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  // the background's colour around the digits keeps them readable where a line passes
  ctx.lineWidth = 3;
  ctx.lineJoin = "round";
  ctx.strokeStyle = back;
  ctx.fillStyle = colour;
  return (/** @type {string} */ text, /** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ angle) => {
    ctx.translate(x, y);
    ctx.rotate(angle);
    ctx.strokeText(text, 0, 0.5);
    ctx.fillText(text, 0, 0.5);
    ctx.rotate(-angle);
    ctx.translate(-x, -y);
  };
}

/** @param {CanvasRenderingContext2D} ctx @param {number[]} lines */
function segments(ctx, lines) {
  for (let k = 0; k < lines.length; k += 4) {
    ctx.moveTo(lines[k], lines[k + 1]);
    ctx.lineTo(lines[k + 2], lines[k + 3]);
  }
}
