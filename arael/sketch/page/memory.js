/** What the browser keeps of one visit for the next; nothing where it may keep nothing. */

const PREFIX = "arael-sketch-";

/** @param {string} key @returns {string|null} */
export function remembered(key) {
  try {
    return localStorage.getItem(PREFIX + key);
  } catch {
    return null; // storage is refused in private windows and sandboxed frames
  }
}

/** @param {string} key @param {string} value */
export function remember(key, value) {
  try {
    localStorage.setItem(PREFIX + key, value);
  } catch {
    // as above: the next visit begins anew
  }
}
