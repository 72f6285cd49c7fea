/** Actions on files: save, import, export. */

/** @typedef {import("../actions.js").Action} Action */

/** Formats that are written, and whether they are read, too. */
export const FORMATS = [
  { id: "dxf", title: "DXF", reads: true },
  { id: "svg", title: "SVG", reads: true },
  { id: "pdf", title: "PDF", reads: false },
  { id: "png", title: "PNG", reads: false },
  { id: "step", title: "STEP", reads: false },
  { id: "json", title: "JSON", reads: false },
];

/** @type {readonly Action[]} */
export const FILING = [
  { id: "save", title: "Save", key: "Ctrl+S", group: "file", run: (app) => app.files?.save() },
  {
    id: "import",
    title: "Import DXF or SVG",
    key: "Ctrl+O",
    group: "file",
    run: (app) => app.files?.open(),
  },
  ...FORMATS.map(({ id, title }) => ({
    id: `export_${id}`,
    title: `Export ${title}`,
    key: "",
    group: "file",
    run: (/** @type {import("../app.js").App} */ app) => app.files?.export(id),
  })),
];
