/** Names of a text as buttons: hovered they point at the drawing, clicked they are selected. */

import { h } from "./dom.js";

/**
 * @typedef {import("./store.js").Store} Store
 * @typedef {import("./dom.js").Child} Child
 */

const NAME = /\b([A-Za-z]+\d+[A-Z]?)(?:\.\.([A-Za-z]+\d+))?(\.[a-z]\w*)?\b/g;

/**
 * Names between two of the same letters: `L0..L3`.
 * @param {string} first
 * @param {string} last
 * @returns {string[]}
 */
export function span(first, last) {
  const a = /^([A-Za-z]+)(\d+)$/.exec(first);
  const b = /^([A-Za-z]+)(\d+)$/.exec(last);
  if (!a || !b || a[1] !== b[1]) return [first, last];
  const from = Number(a[2]);
  const to = Number(b[2]);
  if (to < from || to - from > 10000) return [first, last];
  return Array.from({ length: to - from + 1 }, (_, i) => `${a[1]}${from + i}`);
}

/**
 * A text as pieces: plain, or with the names it stands for.
 * @param {string} text
 * @param {(name: string) => boolean} known
 * @returns {{text: string, names: string[]}[]}
 */
export function pieces(text, known) {
  /** @type {{text: string, names: string[]}[]} */
  const found = [];
  let end = 0;
  for (const match of text.matchAll(NAME)) {
    const [whole, first, last, point] = match;
    if (!known(first)) continue;
    const handle = point && !last && known(first + point) ? first + point : first;
    const names = last ? span(first, last).filter(known) : [handle];
    if (match.index > end) found.push({ text: text.slice(end, match.index), names: [] });
    const shown = last || handle !== first ? whole : first;
    found.push({ text: shown, names });
    end = match.index + shown.length;
  }
  if (end < text.length) found.push({ text: text.slice(end), names: [] });
  return found;
}

/**
 * What lights up in the drawing for a name: a constraint or dimension with what it relates.
 * @param {Store} store
 * @param {Iterable<string>} names
 * @returns {Set<string>}
 */
export function lit(store, names) {
  const found = new Set(names);
  for (const name of [...found]) {
    const record = store.constraints.get(name) ?? store.dimensions.get(name);
    for (const handle of record?.args ?? []) found.add(handle);
    for (const result of store.groups.get(name)?.results ?? []) found.add(result);
  }
  return found;
}

/**
 * Light names up while the pointer or the focus is on an element.
 * @template {HTMLElement} E
 * @param {E} element
 * @param {Store} store
 * @param {() => Iterable<string>} names
 * @returns {E}
 */
export function points(element, store, names) {
  const on = () => store.hover(lit(store, names()));
  const off = () => store.hover([]);
  element.addEventListener("pointerenter", on);
  element.addEventListener("pointerleave", off);
  element.addEventListener("focusin", on);
  element.addEventListener("focusout", off);
  return element;
}

/**
 * A text whose names point at the drawing.
 * @param {Store} store
 * @param {string} text
 * @returns {Child[]}
 */
export function mentioning(store, text) {
  return pieces(text, (name) => store.has(name)).map((piece) =>
    piece.names.length
      ? points(
          h("button", { class: "name", onclick: () => store.select(piece.names) }, piece.text),
          store,
          () => piece.names,
        )
      : piece.text,
  );
}
