/** Keys of the page: to the tool that is active, then to the table of actions. */

import { KeyCursor } from "./key_cursor.js";

/** Elements in which letters are text. */
const TEXT = "input, textarea, select, [contenteditable]";
/** Elements that Enter and the space bar act on. */
const PRESSED = "button, a, summary, [role=option], [role=menuitem], [role=tab]";

/**
 * The name of a key with its modifiers, as in the table: `Shift+R`, `Alt+L`, `Ctrl+Z`, `?`.
 * @param {{key: string, code?: string, ctrlKey?: boolean, metaKey?: boolean, altKey?: boolean, shiftKey?: boolean}} event
 * @returns {string}
 */
export function keyName(event) {
  const ctrl = event.ctrlKey || event.metaKey;
  // with Alt some systems write other characters: the key itself counts
  const letter = /^Key([A-Z])$/.exec(event.code ?? "");
  const digit = /^Digit(\d)$/.exec(event.code ?? "");
  let key = event.key;
  if (event.altKey && letter) key = letter[1];
  else if (event.altKey && digit) key = digit[1];
  else if (/^[a-z]$/i.test(key)) key = key.toUpperCase();
  else if (ctrl && letter) key = letter[1];
  // symbols are written with Shift on some keyboards and without it on others
  const shifted = event.shiftKey && (key.length > 1 || /[A-Z]/.test(key) || event.altKey);
  return `${ctrl ? "Ctrl+" : ""}${event.altKey ? "Alt+" : ""}${shifted ? "Shift+" : ""}${key}`;
}

/** Listens on the root of the page. */
export class Keys {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.cursor = new KeyCursor(app);
    app.root.addEventListener("keydown", (event) => this._down(/** @type {KeyboardEvent} */ (event)));
  }

  /** @param {KeyboardEvent} event */
  _down(event) {
    if (event.defaultPrevented || event.isComposing) return;
    const target = /** @type {HTMLElement} */ (event.target);
    const name = keyName(event);
    if (target.closest("dialog, [role=menu]")) return;
    if (target.closest(TEXT)) {
      if (!/^(Ctrl\+[KS.]|F1|F6)$/.test(name)) return;
    } else if (target.closest(PRESSED) && /^(Enter| |Tab|Shift\+Tab|Arrow\w+)$/.test(name)) return;
    if (this._act(event, name)) event.preventDefault();
  }

  /** @param {KeyboardEvent} event @param {string} name */
  _act(event, name) {
    const { app } = this;
    const drawing = app.root.ownerDocument.activeElement === app.canvas;
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    if (plain && event.key === "Tab" && !drawing) return false;
    if (plain && app.tools.current.typed.open && app.tools.key(event)) return true;
    if (drawing && this.cursor.key(event, name)) return true;
    // Tab leaves the drawing unless the tool has values to type or things to cycle
    if (plain && app.tools.key(event)) return true;
    const action = app.actions.byKey.get(name);
    if (!action) return false;
    app.actions.run(action.id);
    return true;
  }
}
