/** What is still free, and what conflicts: sentences that point at the drawing. */

import { fill, h, later } from "../dom.js";
import { icon } from "../icons.js";
import { mentioning, points } from "../mention.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {{sentence: string, entities: string[], count?: number}} Motion
 * @typedef {{name: string, members: string[], sentence: string}} Conflict
 */

const MOST = 100;
/** Groups of motions that are shown at once. */
const FEW = 6;

/** @param {App} app @param {HTMLElement} element */
export function mount(app, element) {
  const { store, wire } = app;
  const count = h("p", { class: "freedoms" });
  const conflicts = h("div", { class: "conflicts" });
  const motions = h("div", { class: "motions" });
  fill(element, count, conflicts, motions);
  let asked = 0;
  // a new verdict leaves the list open that the person has opened
  const opened = { each: false };

  async function ask() {
    if (!app.panels?.isOpen("freedom")) return;
    const mine = ++asked;
    const [free, bad] = await Promise.all([wire.ask("free"), wire.ask("conflicts")]);
    if (mine !== asked || !free.ok || !bad.ok) return;
    const { motions: moving = [], groups = moving } = /** @type {{motions?: Motion[], groups?: Motion[]}} */ (free.data ?? {});
    const wrong = /** @type {{conflicts: Conflict[]}|undefined} */ (bad.data)?.conflicts ?? [];
    const total = moving.length;
    if (!store.entities.size) fill(count, "The sketch is empty.");
    else if (total === 0) fill(count, icon("defined"), "Fully defined: nothing can move.");
    else fill(count, h("strong", {}, String(total)), total === 1 ? " degree of freedom" : " degrees of freedom");
    fill(conflicts, ...(wrong.length ? [h("h3", {}, "Redundant or in conflict"), list(wrong.map((one) => conflict(app, one)))] : []));
    fill(motions, ...(total ? [h("h3", {}, "Still free"), ...few(app, groups)] : []));
    if (groups.length < total || groups.length > FEW) motions.append(each(app, moving, opened));
  }
  const soon = later(150, ask);
  for (const type of ["verdict", "change"]) store.addEventListener(type, soon);
  store.addEventListener("change", () => {
    if (store.entities.size && !store.isJudged) fill(count, "checking ...");
  });
  return { show: ask };
}

/** @param {HTMLElement[]} items */
const list = (items) => h("ul", { class: "sentences" }, ...items);

/** The first groups, and how many degrees of freedom the others have. @param {App} app @param {Motion[]} groups */
function few(app, groups) {
  const rest = groups.slice(FEW).reduce((sum, one) => sum + (one.count ?? 1), 0);
  const shown = list(groups.slice(0, FEW).map((one) => motion(app, one)));
  return rest ? [shown, h("p", { class: "count" }, `and ${rest} more`)] : [shown];
}

/** Every motion, when it is asked for. @param {App} app @param {Motion[]} moving @param {{each: boolean}} opened */
function each(app, moving, opened) {
  const found = h("details", { class: "each", open: opened.each }, h("summary", {}, "One by one"));
  found.addEventListener("toggle", () => {
    opened.each = found.open;
    if (!found.open || found.children.length > 1) return;
    found.append(list(moving.slice(0, MOST).map((one) => motion(app, one))));
    if (moving.length > MOST) found.append(h("p", { class: "count" }, `and ${moving.length - MOST} more`));
  });
  return found;
}

/** @param {App} app @param {Motion} one */
function motion(app, one) {
  const count = (one.count ?? 1) > 1 ? h("span", { class: "ways", title: "degrees of freedom" }, `×${one.count}`) : null;
  const item = h("li", { class: "sentence", tabindex: 0 }, h("span", {}, ...mentioning(app.store, one.sentence)), count);
  return points(item, app.store, () => one.entities);
}

/** @param {App} app @param {Conflict} one */
function conflict(app, one) {
  const relation = app.store.constraints.has(one.name) || app.store.dimensions.has(one.name);
  const drop = [one.name, ...one.members].slice(0, relation ? 6 : 0).map((name, i) =>
    points(
      h(
        "button",
        { class: `button ${i ? "" : "primary"}`, onclick: () => app.run(`delete ${name}`) },
        i ? name : `Delete ${name}`,
      ),
      app.store,
      () => [name],
    ),
  );
  const item = h(
    "li",
    { class: "sentence conflict", tabindex: 0 },
    icon("warning"),
    h("span", {}, ...mentioning(app.store, one.sentence)),
    drop.length ? h("div", { class: "offers" }, ...drop.slice(0, 1), drop.length > 1 ? "or" : null, ...drop.slice(1)) : null,
  );
  return points(item, app.store, () => [one.name, ...one.members]);
}
