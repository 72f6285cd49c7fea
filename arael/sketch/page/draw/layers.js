/** The canvases that lie on each other. */

/**
 * @typedef {object} Layer
 * @property {HTMLCanvasElement} canvas
 * @property {CanvasRenderingContext2D} ctx  to draw with
 * @property {(width: number, height: number) => void} resize  in pixels of the screen; it is blank afterwards
 * @property {() => void} done  what was drawn is to be seen
 */

/** A canvas that is drawn on directly. @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2DSettings} [options] @returns {Layer} */
export function livelyLayer(canvas, options) {
  const ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", options));
  return { canvas, ctx, resize: (width, height) => sized(canvas, width, height), done() {} };
}

/**
 * A canvas that rests in a drag, without holes. It is drawn apart and shown as an image: without a graphics
 * processor Chromium copies every canvas that is drawn on directly for each refresh of the screen, whether it
 * has changed or not.
 * @param {HTMLCanvasElement} canvas @returns {Layer}
 */
export function stillLayer(canvas) {
  const shown = typeof OffscreenCanvas === "undefined" ? null : canvas.getContext("bitmaprenderer", { alpha: false });
  if (!shown) return livelyLayer(canvas, { alpha: false });
  const sheet = new OffscreenCanvas(1, 1);
  const ctx = /** @type {CanvasRenderingContext2D} */ (/** @type {unknown} */ (sheet.getContext("2d", { alpha: false })));
  return {
    canvas,
    ctx,
    resize: (width, height) => {
      sized(sheet, width, height);
      sized(canvas, width, height);
    },
    done: () => shown.transferFromImageBitmap(sheet.transferToImageBitmap()),
  };
}

/**
 * Two layers in place of one, a clear one and one without holes, which has a copy of what is below it. They go to
 * the screen by themselves, not with the page: without a graphics processor that saves the page's thread half of
 * its time for a refresh, and the compositor half of its own where it need not lay one canvas over another. What
 * they show can be one refresh ahead of the other canvases, unless it becomes visible, or hidden, together with
 * what those show.
 * @param {Layer} layer
 */
export function ownLayers({ canvas }) {
  const layers = [true, false].map((alpha) => {
    const own = /** @type {HTMLCanvasElement} */ (canvas.cloneNode());
    if (!alpha) own.id = "filled";
    canvas.before(own);
    const layer = livelyLayer(own, { desynchronized: true, alpha });
    show(layer, false);
    // its first frame comes late to the screen
    layer.ctx.clearRect(0, 0, 1, 1);
    return layer;
  });
  canvas.remove();
  return layers;
}

/**
 * The screen is put together from every canvas that is shown, for each refresh: one with nothing on it is hidden.
 * @param {Layer} layer @param {boolean} on
 */
export function show({ canvas: { style } }, on) {
  const visibility = on ? "" : "hidden";
  if (style.visibility !== visibility) style.visibility = visibility;
}

/** Whether the browser draws without a graphics processor, as far as it says. */
export function drawsBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  return !gl || (!!info && /swiftshader|llvmpipe|soft|basic/i.test(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)));
}

/** @param {HTMLCanvasElement|OffscreenCanvas} canvas @param {number} width @param {number} height */
function sized(canvas, width, height) {
  canvas.width = width;
  canvas.height = height;
}
