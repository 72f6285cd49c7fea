/**
 * What draws a drag is compiled by the browser while its first frames are drawn, which take several times as
 * long as those after them. It is done before, when the page has nothing else to do.
 */

/** Frames after which the browser has compiled what it will. */
const FRAMES = 150;
/** Milliseconds that the page has to have left for a frame. */
const ENOUGH = 8;
/** Milliseconds of a frame after which none follows: a page that is asked for something meanwhile waits for it. */
const LONG = 50;

/**
 * @param {() => boolean} draw  a frame off the screen; false: not now
 * @returns {() => void}  asks for the frames that are still to be drawn
 */
export function rehearsal(draw) {
  let left = FRAMES;
  let waits = false;
  /** @param {IdleDeadline} idle */
  const go = (idle) => {
    waits = false;
    while (left && idle.timeRemaining() > ENOUGH) {
      const began = performance.now();
      if (!draw()) return;
      left = performance.now() - began > LONG ? 0 : left - 1;
    }
    ask();
  };
  const ask = () => {
    if (!left || waits || !window.requestIdleCallback) return;
    waits = true;
    requestIdleCallback(go);
  };
  return ask;
}
