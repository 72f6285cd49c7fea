/** Files that come from and go to the browser: import, downloads; saving on the server. */

import { fill, h } from "./dom.js";
import { mentioning } from "./mention.js";

/** @typedef {import("./app.js").App} App */

/** Bytes as base64. @param {Uint8Array} bytes */
export function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** @param {string} text @returns {Uint8Array<ArrayBuffer>} */
export function bytes(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

export class Files {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.picker = h("input", { type: "file", accept: ".dxf,.svg", hidden: true, "aria-label": "file to import" });
    app.root.append(this.picker);
    this.picker.addEventListener("change", () => {
      const file = this.picker.files?.[0];
      this.picker.value = "";
      if (file) this.import(file);
    });
    app.canvas.addEventListener("dragover", (event) => event.preventDefault());
    app.canvas.addEventListener("drop", (event) => {
      event.preventDefault();
      const file = event.dataTransfer?.files[0];
      if (file) this.import(file);
    });
  }

  /** Ask for a file to import. */
  open() {
    this.picker.click();
  }

  async save() {
    const reply = await this.app.wire.file({ do: "save" });
    if (reply.ok) this.app.notes?.show({ level: "info", text: reply.text, key: "file" });
    else this.app.notes?.refused(reply, "");
  }

  /** @param {File} file */
  async import(file) {
    const { app } = this;
    const format = file.name.split(".").pop()?.toLowerCase() ?? "";
    const data = base64(new Uint8Array(await file.arrayBuffer()));
    const reply = await app.wire.file({ do: "import", format, name: file.name, data });
    if (!reply.ok) {
      app.notes?.refused(reply, "");
      return;
    }
    app.fit();
    const found = /** @type {{suggestions?: (string|{command: string})[]}|undefined} */ (reply.data)?.suggestions ?? [];
    const commands = found.map((one) => (typeof one === "string" ? one : one.command));
    app.notes?.show({ level: "info", text: [reply.text, ...(reply.notes ?? [])].join("\n"), key: "file" });
    if (commands.length) this._suggest(commands);
  }

  /**
   * Relations that were found in a drawing, to be accepted all or in part.
   * @param {string[]} commands
   */
  _suggest(commands) {
    const { app } = this;
    /** @type {Map<string, HTMLInputElement[]>} */
    const kinds = new Map();
    for (const text of commands) {
      const kind = text.split(" ")[0];
      if (!kinds.has(kind)) kinds.set(kind, []);
      kinds.get(kind)?.push(/** @type {HTMLInputElement} */ (h("input", { type: "checkbox", checked: true, value: text })));
    }
    const dialog = h("dialog", { class: "dialog", "aria-label": "relations that were found" });
    const accept = async () => {
      const chosen = [...kinds.values()].flat().filter((box) => box.checked).map((box) => box.value);
      dialog.close();
      if (!chosen.length) return;
      const [first, ...extras] = chosen;
      await app.run(first, { extras, step: "accept relations" });
    };
    fill(
      dialog,
      h("h2", {}, `${commands.length} relations were found in the drawing`),
      h("p", { class: "hint" }, "Those that are marked become constraints."),
      h("ul", { class: "suggestions" }, ...[...kinds].map(([kind, boxes]) => this._kind(kind, boxes))),
      h(
        "div",
        { class: "dialog-buttons" },
        h("button", { class: "button", onclick: () => dialog.close() }, "None"),
        h("button", { class: "button primary", onclick: accept }, "Accept"),
      ),
    );
    dialog.addEventListener("close", () => dialog.remove());
    app.root.append(dialog);
    dialog.showModal();
  }

  /**
   * Relations of one kind: one box for all of them, and one for each when it is opened.
   * @param {string} kind
   * @param {HTMLInputElement[]} boxes
   */
  _kind(kind, boxes) {
    const all = /** @type {HTMLInputElement} */ (h("input", { type: "checkbox", checked: true, "aria-label": `all ${kind}` }));
    all.addEventListener("change", () => {
      for (const box of boxes) box.checked = all.checked;
    });
    const count = () => {
      const marked = boxes.filter((box) => box.checked).length;
      all.checked = marked === boxes.length;
      all.indeterminate = marked > 0 && marked < boxes.length;
    };
    for (const box of boxes) box.addEventListener("change", count);
    const one = (/** @type {HTMLInputElement} */ box) =>
      h("li", {}, h("label", {}, box, h("span", {}, ...mentioning(this.app.store, box.value))));
    return h(
      "li",
      {},
      h("details", {}, h("summary", {}, all, ` ${boxes.length} ${kind.replaceAll("_", " ")}`), h("ul", {}, ...boxes.map(one))),
    );
  }

  /**
   * @param {string} format
   * @param {string} [sheet] size of the paper, of PDF
   */
  async export(format, sheet = "") {
    const { app } = this;
    const name = (app.store.file || "sketch").replace(/\.[^.]*$/, "");
    const date = new Date().toLocaleDateString("sv"); // 2026-01-31
    const reply = await app.wire.file({ do: "export", format, name, ...(sheet ? { sheet, date } : {}) });
    const file = /** @type {{file?: {name: string, data: string}}} */ (/** @type {unknown} */ (reply)).file;
    if (!reply.ok || !file) {
      app.notes?.refused(reply, "");
      return;
    }
    const url = URL.createObjectURL(new Blob([bytes(file.data)]));
    const link = h("a", { href: url, download: file.name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
    app.notes?.show({ level: "info", text: `Exported ${file.name}`, key: "file" });
  }
}
