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

/** Sizes of paper of a drawing with frame and title block. */
export const SHEETS = ["A4", "A3", "A2", "A1"];

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
  ...SHEETS.map((sheet) => ({
    id: `export_${sheet.toLowerCase()}`,
    title: `Export a sheet ${sheet} as PDF`,
    key: "",
    group: "file",
    run: (/** @type {import("../app.js").App} */ app) => app.files?.export("pdf", sheet),
  })),
  ...FORMATS.map(({ id, title }) => ({
    id: `export_${id}`,
    title: `Export ${title}`,
    key: "",
    group: "file",
    run: (/** @type {import("../app.js").App} */ app) => app.files?.export(id),
  })),
];
