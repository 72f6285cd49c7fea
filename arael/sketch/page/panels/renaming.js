/** The name of what is selected alone, as a field: Enter takes it, Escape leaves it as it was. */

import { fill, h } from "../dom.js";
import { failure } from "../failure.js";
import { picked } from "../picked.js";
import { argument } from "../tools/compose.js";

/**
 * The entity or dimension that is selected alone, "" if there is none.
 * @param {import("../store.js").Store} store
 */
export function renamable(store) {
  const { all, entities, dimensions } = picked(store);
  return all.length === 1 ? entities[0] ?? dimensions[0] ?? "" : "";
}

/**
 * Put a field in the place of a name.
 * @param {import("../app.js").App} app
 * @param {HTMLElement} place
 * @param {string} before  the name
 * @param {() => void} close  puts back what was in the place
 */
export function rename(app, place, before, close) {
  const props = { type: "text", class: "cell", autocomplete: "off", autocapitalize: "off", spellcheck: "false" };
  const field = h("input", { ...props, "aria-label": `new name of ${before}` });
  const problem = h("div", { class: "row-problem", role: "alert" });
  async function commit() {
    const now = field.value.trim();
    const command = `rename ${before} ${argument(now)}`;
    const reply = now && now !== before ? await app.wire.run(command) : null;
    field.toggleAttribute("aria-invalid", reply?.ok === false);
    fill(problem, reply?.ok === false ? failure(app, reply, command, "") : null);
    if (reply?.ok === false) return;
    if (reply) app.store.select([now]);
    close();
  }
  field.addEventListener("keydown", (event) => {
    if (event.key === "Enter") void commit();
    else if (event.key === "Escape") close();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  field.value = before;
  fill(place, field, problem);
  field.focus();
  field.select();
}
