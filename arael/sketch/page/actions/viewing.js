/** Actions on what is shown: view, grid, theme, panels, help. */

/**
 * @typedef {import("../actions.js").Action} Action
 * @typedef {import("../app.js").App} App
 */

const STEP = 1.25;

/** @param {App} app @param {number} factor */
const zoom = (app, factor) => app.view.zoomAt(app.view.width / 2, app.view.height / 2, factor);

/** What can be hidden, by the name of a data attribute of the root; the renderer reads `app.shown`. */
export const LAYERS = [
  { id: "dimensions", title: "Dimensions", key: "Alt+Shift+D" },
  { id: "glyphs", title: "All constraint marks", key: "Z" },
  { id: "points", title: "Points", key: "Alt+Shift+I" },
  { id: "construction", title: "Construction geometry", key: "Alt+Shift+X" },
  { id: "regions", title: "Closed regions", key: "Alt+Shift+U" },
];

/** Panels in the order of their tabs. */
export const PANELS = [
  { id: "selection", title: "Selection", key: "1" },
  { id: "parameters", title: "Parameters", key: "2" },
  { id: "relations", title: "Constraints", key: "3" },
  { id: "freedom", title: "Freedom", key: "4" },
  { id: "history", title: "History", key: "5" },
];

/** @type {readonly Action[]} */
export const VIEWING = [
  {
    id: "fit",
    title: "Show everything",
    key: "Home",
    also: ["."],
    group: "view",
    run: (app) => app.fit(),
  },
  { id: "zoom_in", title: "Zoom in", key: "+", also: ["="], group: "view", run: (app) => zoom(app, STEP) },
  { id: "zoom_out", title: "Zoom out", key: "-", group: "view", run: (app) => zoom(app, 1 / STEP) },
  {
    id: "grid",
    title: "Grid",
    key: "#",
    group: "view",
    checked: (app) => app.view.grid,
    run: (app) => app.view.setGrid(!app.view.grid),
  },
  ...LAYERS.map(({ id, title, key }) => ({
    id: `show_${id}`,
    title,
    key,
    group: "view",
    checked: (/** @type {App} */ app) => app.shown[id],
    run: (/** @type {App} */ app) => app.show(id, !app.shown[id]),
  })),
  {
    id: "theme",
    title: "Dark, light or as the system",
    key: "Alt+Shift+L",
    group: "view",
    run: (app) => app.theme?.next(),
  },
  ...PANELS.map(({ id, title, key }) => ({
    id: `panel_${id}`,
    title: `Panel: ${title}`,
    key,
    group: "panels",
    run: (/** @type {App} */ app) => app.panels?.toggle(id),
  })),
  {
    id: "command",
    title: "Command field",
    key: "/",
    also: [":"],
    group: "panels",
    run: (app) => app.field?.open(),
  },
  {
    id: "actions",
    title: "Find an action",
    key: "Ctrl+K",
    group: "panels",
    run: (app) => app.help?.open("keys"),
  },
  { id: "keys", title: "Keys and tools", key: "?", group: "help", run: (app) => app.help?.open("keys") },
  {
    id: "manual",
    title: "Manual of commands",
    key: "F1",
    group: "help",
    run: (app) => app.help?.open("manual"),
  },
  { id: "tour", title: "Tour", key: "Shift+F1", group: "help", run: (app) => app.tour?.start() },
  {
    id: "break",
    title: "Break off what runs",
    key: "Ctrl+.",
    group: "help",
    run: (app) => app.wire.breakOff(),
  },
  {
    id: "focus_canvas",
    title: "Go to the drawing",
    key: "F6",
    group: "panels",
    run: (app) => app.canvas.focus(),
  },
];
