/** Another unit for the part: a person says whether its size stays (convert) or its numbers do (relabel). */

import { fill, h } from "./dom.js";
import { MILLIMETRES, UNITS } from "./lengths.js";

/** @param {import("./app.js").App} app */
export function askPartUnit(app) {
  const now = app.store.unit;
  const options = UNITS.filter((unit) => unit !== now).map((unit) => h("option", { value: unit }, unit));
  const select = h("select", { class: "cell", "aria-label": "new unit of the part" }, ...options);
  const convert = h("p", { class: "hint" });
  const relabel = h("p", { class: "hint" });
  const explain = () => {
    const unit = select.value;
    const number = Number(((40 * MILLIMETRES[now]) / MILLIMETRES[unit]).toPrecision(6));
    convert.textContent = `Convert: the part keeps its size, 40 ${now} become ${number} ${unit}.`;
    relabel.textContent = `Relabel: numbers stay, 40 ${now} become 40 ${unit}, so that the size of the part changes.`;
  };
  select.addEventListener("change", explain);
  explain();
  const dialog = h("dialog", { class: "dialog", "aria-label": "unit of the part" });
  const run = (/** @type {string} */ how) => {
    dialog.close();
    void app.run(`settings unit ${select.value} ${how}`);
  };
  fill(
    dialog,
    h("h2", {}, `Lengths of this part are in ${now}`),
    h("label", {}, "New unit: ", select),
    convert,
    relabel,
    h(
      "div",
      { class: "dialog-buttons" },
      h("button", { class: "button", onclick: () => dialog.close() }, "Cancel"),
      h("button", { class: "button", onclick: () => run("relabel") }, "Relabel"),
      h("button", { class: "button primary", onclick: () => run("convert") }, "Convert"),
    ),
  );
  dialog.addEventListener("close", () => dialog.remove());
  app.root.append(dialog);
  dialog.showModal();
}
