/** Elements of the page, made in one call. */

/**
 * @typedef {Node|string|number|null|undefined|false} Child
 * @typedef {Record<string, unknown>} Props
 */

/**
 * An element. Properties that begin with `on` are listeners, the others attributes; `true` sets an
 * attribute without a value, `false`, `null` and `undefined` leave it out.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Props} [props]
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function h(tag, props = {}, ...children) {
  const element = document.createElement(tag);
  // one without a type would send the form that it is in
  const all = tag === "button" ? { type: tag, ...props } : props;
  for (const [name, value] of Object.entries(all)) {
    if ((value ?? false) === false) continue;
    if (name.startsWith("on")) {
      element.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
    } else element.setAttribute(name, value === true ? "" : String(value));
  }
  put(element, children);
  return element;
}

/**
 * Put children at the end of an element.
 * @param {Element} element
 * @param {Child[]} children
 */
export function put(element, children) {
  for (const child of children) {
    if ((child ?? false) === false) continue;
    element.append(child instanceof Node ? child : String(child));
  }
}

/**
 * Put children in place of what an element holds.
 * @param {Element} element
 * @param {...Child} children
 */
export function fill(element, ...children) {
  element.replaceChildren();
  put(element, children);
}

/**
 * The element of a class or id below another one.
 * @param {ParentNode} root
 * @param {string} selector
 * @returns {HTMLElement}
 * @throws {Error} if there is none
 */
export function part(root, selector) {
  const found = root.querySelector(selector);
  if (!(found instanceof HTMLElement)) throw new Error(`the page has no ${selector}`);
  return found;
}

/**
 * Call a function once in the next frame, however often it is asked for.
 * @param {() => void} work
 * @returns {() => void}
 */
export function once(work) {
  let waits = false;
  return () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      work();
    });
  };
}

/**
 * Call a function at most once in a while: a little after it was asked for, and not again before.
 * @param {number} milliseconds
 * @param {() => void} work
 * @returns {() => void}
 */
export function seldom(milliseconds, work) {
  let timer = 0;
  return () => {
    timer ||= window.setTimeout(() => {
      timer = 0;
      work();
    }, milliseconds);
  };
}

/**
 * Call a function when nothing asked for it for a while.
 * @template {unknown[]} A
 * @param {number} milliseconds
 * @param {(...given: A) => void} work
 * @returns {(...given: A) => void}
 */
export function later(milliseconds, work) {
  let timer = 0;
  return (...given) => {
    clearTimeout(timer);
    timer = window.setTimeout(() => work(...given), milliseconds);
  };
}

/**
 * Move the focus among the focusable children of an element by arrow keys, Home and End.
 * @param {HTMLElement} element
 * @param {string} selector  of the children
 * @param {"vertical"|"horizontal"|"both"} [axis]
 */
export function roving(element, selector, axis = "vertical") {
  const forward = axis === "vertical" ? ["ArrowDown"] : ["ArrowRight", "ArrowDown"];
  const back = axis === "vertical" ? ["ArrowUp"] : ["ArrowLeft", "ArrowUp"];
  element.addEventListener("keydown", (event) => {
    const all = /** @type {HTMLElement[]} */ ([...element.querySelectorAll(selector)]).filter(
      (one) => one.offsetParent !== null,
    );
    const at = all.indexOf(/** @type {HTMLElement} */ (document.activeElement));
    if (at < 0) return;
    let next = -1;
    if (forward.includes(event.key)) next = (at + 1) % all.length;
    else if (back.includes(event.key)) next = (at + all.length - 1) % all.length;
    else if (event.key === "Home") next = 0;
    else if (event.key === "End") next = all.length - 1;
    if (next < 0) return;
    event.preventDefault();
    event.stopPropagation();
    all[next].focus();
  });
}
