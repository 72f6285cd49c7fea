/**
 * The page in a notebook: an anywidget module that runs it in a frame, over the widget's messages.
 *
 * The kernel sends the page's files. Each module becomes a blob URL, those first that others import;
 * the frame keeps ids, keys and styles of the page apart from the notebook's.
 */

/**
 * @typedef {object} Model  of anywidget
 * @property {(content: object, callbacks?: unknown, buffers?: ArrayBuffer[]) => void} send
 * @property {(event: string, handler: (content: any, buffers: DataView[]) => void) => void} on
 * @property {(event: string, handler: (content: any, buffers: DataView[]) => void) => void} off
 *
 * @typedef {import("./transport.js").Handlers} Handlers
 * @typedef {import("./transport.js").Connect} Connect
 */

const HEIGHT = "640px";
const IMPORT = /(\bfrom\s*|\bimport\s*\(?\s*)(["'])(\.{1,2}\/[^"']+)\2/g;

/**
 * The path that a module's import means.
 * @param {string} from  path of the importing module
 * @param {string} to  as it is written there
 * @returns {string}
 */
export function resolved(from, to) {
  const parts = from.split("/").slice(0, -1);
  for (const part of to.split("/")) {
    if (part === "..") parts.pop();
    else if (part !== ".") parts.push(part);
  }
  return parts.join("/");
}

/** @param {string} text  without comments, in which `import("...")` names types */
function bare(text) {
  return text.replace(/\/\*[\s\S]*?\*\//g, "").replace(/^\s*\/\/.*$/gm, "");
}

/**
 * Modules in an order in which each comes after those that it imports.
 * @param {Record<string, string>} files  text by path
 * @param {string} first  the module that is wanted
 * @returns {string[]}
 */
export function inOrder(files, first) {
  /** @type {Map<string, boolean>} */
  const done = new Map();
  /** @type {string[]} */
  const order = [];
  /** @param {string} path */
  const visit = (path) => {
    if (done.has(path)) {
      if (!done.get(path)) throw new Error(`a circle of imports at ${path}`);
      return;
    }
    if (!(path in files)) throw new Error(`no module ${path}`);
    done.set(path, false);
    for (const found of bare(files[path]).matchAll(IMPORT)) visit(resolved(path, found[3]));
    done.set(path, true);
    order.push(path);
  };
  visit(first);
  return order;
}

/**
 * A blob URL of every module, by path.
 * @param {Record<string, string>} files
 * @param {string} first
 * @param {(text: string) => string} makeUrl
 * @returns {Map<string, string>}
 */
export function moduleUrls(files, first, makeUrl) {
  /** @type {Map<string, string>} */
  const urls = new Map();
  for (const path of inOrder(files, first)) {
    const text = files[path].replace(IMPORT, (all, head, quote, to) => {
      const url = urls.get(resolved(path, to));
      return url ? `${head}${quote}${url}${quote}` : all; // types, in comments
    });
    urls.set(path, makeUrl(text));
  }
  return urls;
}

/**
 * The frame's document: index.html with its styles inside, started by the notebook's transport.
 * @param {Record<string, string>} files
 * @param {string} main  URL of main.js
 * @returns {string}
 */
export function frameDocument(files, main) {
  return files["index.html"]
    .replace(/<link rel="stylesheet" href="([^"]+)">/g, (_all, path) => `<style>${files[path]}</style>`)
    .replace(
      /<script type="module" src="page\.js"><\/script>/,
      `<script type="module">
import { start } from "${main}";
window.app = start(document.body, window.frameElement.araelConnect);
</script>`,
    );
}

/**
 * A transport over the widget's messages.
 * @param {Model} model
 * @param {string} window  identifies this view
 * @returns {Connect}
 */
function overWidget(model, window) {
  return (since, handlers) => {
    /** @type {(content: any, buffers: DataView[]) => void} */
    const receive = (content, buffers) => {
      if (content.window !== window) return;
      if (content.type === "page") {
        const { buffer, byteOffset, byteLength } = buffers[0];
        handlers.onmessage(/** @type {ArrayBuffer} */ (buffer.slice(byteOffset, byteOffset + byteLength)));
      } else if (content.type === "refused") {
        handlers.onclose();
      }
    };
    model.on("msg:custom", receive);
    model.send({ type: "open", window, since });
    queueMicrotask(handlers.onopen);
    return {
      send: (buffer) => model.send({ type: "page", window }, undefined, [buffer]),
      close: () => {
        model.off("msg:custom", receive);
        model.send({ type: "close", window });
      },
    };
  };
}

/**
 * Show the editor; of anywidget.
 * @param {{model: Model, el: HTMLElement}} view
 */
function render({ model, el }) {
  const window = `view${Math.random().toString(36).slice(2)}`;
  const frame = document.createElement("iframe");
  frame.style.cssText = `box-sizing: border-box; width: 100%; height: ${HEIGHT}; border: 1px solid #8888; border-radius: 4px`;
  frame.title = "sketch editor";
  Object.assign(frame, { araelConnect: overWidget(model, window) });
  /** @type {string[]} */
  const made = [];
  /** @param {any} content */
  const receive = (content) => {
    if (content.type !== "files" || content.window !== window) return;
    model.off("msg:custom", receive);
    const urls = moduleUrls(content.files, "main.js", (text) => {
      const url = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
      made.push(url);
      return url;
    });
    frame.srcdoc = frameDocument(content.files, urls.get("main.js") ?? "");
    el.append(frame);
  };
  model.on("msg:custom", receive);
  model.send({ type: "files", window });
  return () => {
    model.send({ type: "close", window });
    for (const url of made) URL.revokeObjectURL(url);
  };
}

export default { render };
