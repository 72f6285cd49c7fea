/** Actions that change what is there: undo, deleting, looks, switching on and off. */

import { isExpression } from "../draw/texts.js";
import { renamable } from "../panels/renaming.js";
import { only, picked } from "../picked.js";
import { quoted } from "../tools/compose.js";

/**
 * @typedef {import("../actions.js").Action} Action
 * @typedef {import("../app.js").App} App
 */

/** @param {App} app @param {(one: import("../picked.js").Picked) => string[]} names */
const some = (app, names) => names(picked(app.store)).length > 0;

/**
 * A command on what of the selection a list holds.
 * @param {App} app
 * @param {string} word
 * @param {string[]} names
 * @param {string} [after]
 */
const on = (app, word, names, after = "") => app.run([word, ...names, after].join(" ").trim());

/** @param {"switch_on"|"switch_off"} word @param {App} app */
const switching = (word, app) => on(app, word, picked(app.store).relations);

/** @type {readonly Action[]} */
export const EDITING = [
  {
    id: "undo",
    title: "Undo",
    key: "Ctrl+Z",
    group: "edit",
    enabled: (app) => app.store.history.done.length > 0,
    run: (app) => app.run("undo"),
  },
  {
    id: "redo",
    title: "Redo",
    key: "Ctrl+Shift+Z",
    also: ["Ctrl+Y"],
    group: "edit",
    enabled: (app) => app.store.history.undone.length > 0,
    run: (app) => app.run("redo"),
  },
  {
    id: "delete",
    title: "Delete",
    key: "Delete",
    also: ["Backspace"],
    group: "edit",
    enabled: (app) => app.store.selection.size > 0,
    run: (app) => {
      // a point of a curve cannot be deleted by itself, its curve can
      const names = [...app.store.selection].map((name) => name.split(".")[0]);
      return on(app, "delete", [...new Set(names)]);
    },
  },
  {
    id: "select_all",
    title: "Select all",
    key: "Ctrl+A",
    group: "edit",
    run: (app) => app.store.select(app.store.entities.keys()),
  },
  {
    id: "deselect",
    title: "Deselect",
    key: "Ctrl+Shift+A",
    group: "edit",
    enabled: (app) => app.store.selection.size > 0,
    run: (app) => app.store.select([]),
  },
  {
    id: "construction",
    title: "Construction geometry",
    key: "X",
    group: "edit",
    needs: "entities",
    enabled: (app) => some(app, (one) => one.entities),
    run: (app) => on(app, "constr", picked(app.store).entities),
  },
  {
    id: "quiet",
    title: "Hide dimensions of",
    key: "Shift+X",
    group: "edit",
    needs: "entities",
    enabled: (app) => some(app, (one) => one.entities),
    run: (app) => on(app, "quiet", picked(app.store).entities),
  },
  ...["solid", "dashed", "dashdot"].map((style, i) => ({
    id: `style_${style}`,
    title: `Line style: ${style}`,
    key: `Alt+${i + 1}`,
    group: "edit",
    needs: "entities",
    enabled: (/** @type {App} */ app) => some(app, (one) => one.entities),
    run: (/** @type {App} */ app) => on(app, "style", picked(app.store).entities, style),
  })),
  {
    id: "freeze",
    title: "Dimension everything as it is",
    key: "Alt+F",
    group: "edit",
    enabled: (app) => app.store.entities.size > 0,
    run: (app) => on(app, "freeze", picked(app.store).entities),
  },
  {
    id: "image",
    title: "Image: a turned or shifted copy",
    key: "Alt+I",
    group: "edit",
    needs: "two entities of one kind",
    enabled: (app) => picked(app.store).entities.length === 2,
    run: (app) => app.field?.open(`image ${picked(app.store).entities.join(" ")} shift `),
  },
  {
    id: "set_derived",
    title: "Driven dimension (reference)",
    key: "Alt+M",
    group: "edit",
    needs: "dimensions",
    enabled: (app) => some(app, (one) => (only(one, one.dimensions) ? one.dimensions : [])),
    run: (app) => runEach(app, "set_derived"),
  },
  {
    id: "set_driven",
    title: "Driving dimension",
    key: "Alt+N",
    group: "edit",
    needs: "dimensions",
    enabled: (app) => some(app, (one) => (only(one, one.dimensions) ? one.dimensions : [])),
    run: (app) => runEach(app, "set_driven"),
  },
  {
    id: "snapshot",
    title: "Keep the value, drop the expression",
    key: "Alt+Shift+V",
    group: "edit",
    needs: "dimensions with an expression",
    enabled: (app) => expressions(app).length > 0,
    run: (app) => app.run(expressions(app).map(({ name, value }) => `set_driven ${name} ${quoted(`=${value?.text}`)}`).join("; ")),
  },
  {
    id: "switch_off",
    title: "Switch off",
    key: "Alt+J",
    group: "edit",
    needs: "constraints or dimensions",
    enabled: (app) => some(app, (one) => one.relations),
    run: (app) => switching("switch_off", app),
  },
  {
    id: "switch_on",
    title: "Switch on",
    key: "Alt+K",
    group: "edit",
    needs: "constraints or dimensions",
    enabled: (app) => some(app, (one) => one.relations),
    run: (app) => switching("switch_on", app),
  },
  {
    id: "edit_value",
    title: "Edit the value",
    key: "F2",
    group: "edit",
    needs: "a dimension or a text",
    enabled: (app) => picked(app.store).dimensions.length === 1 || textOf(app) !== null,
    run: (app) => {
      const text = textOf(app);
      if (text) app.editText(text);
      else app.typing?.edit?.(picked(app.store).dimensions[0]);
    },
  },
  {
    id: "rename",
    title: "Rename",
    key: "Shift+F2",
    group: "edit",
    needs: "an entity or a dimension",
    enabled: (app) => renamable(app.store) !== "",
    run: (app) => {
      app.panels?.show("selection");
      app.dispatchEvent(new Event("rename"));
    },
  },
];

/** Dimensions of the selection whose value is an expression. @param {App} app */
function expressions(app) {
  const all = picked(app.store).dimensions.map((name) => app.store.dimensions.get(name));
  return all.filter((one) => one !== undefined).filter(isExpression);
}

/** @param {App} app @param {string} word */
function runEach(app, word) {
  return app.run(picked(app.store).dimensions.map((name) => `${word} ${name}`).join("; "));
}

/** The text that is selected alone. @param {import("../app.js").App} app */
function textOf(app) {
  const { all } = picked(app.store);
  const entity = all.length === 1 ? app.store.entities.get(all[0]) : undefined;
  return entity?.text ? entity : null;
}
