import assert from "node:assert/strict";
import { test } from "node:test";
import { frameDocument, inOrder, moduleUrls, resolved } from "../../arael/sketch/page/notebook.js";

const FILES = {
  "main.js": 'import { a } from "./draw/a.js";\nimport { b } from "./b.js";\nexport { a, b };',
  "b.js": '/** @type {import("./types.js").T} */\nexport const b = 1;',
  "draw/a.js": 'import {\n  b,\n} from "../b.js";\nexport const a = b;',
  "index.html":
    '<link rel="stylesheet" href="s.css"><script type="module" src="page.js"></script><main></main>',
  "s.css": "main { color: red }",
};

test("paths are resolved from the importing module", () => {
  assert.equal(resolved("draw/a.js", "../b.js"), "b.js");
  assert.equal(resolved("draw/a.js", "./c/d.js"), "draw/c/d.js");
  assert.equal(resolved("main.js", "./b.js"), "b.js");
});

test("modules come after those that they import", () => {
  assert.deepEqual(inOrder(FILES, "main.js").at(-1), "main.js");
  const order = inOrder(FILES, "main.js");
  assert.ok(order.indexOf("b.js") < order.indexOf("draw/a.js"));
});

test("imports become addresses, comments stay", () => {
  const texts = new Map();
  const urls = moduleUrls(FILES, "main.js", (text) => {
    const url = `blob:${texts.size}`;
    texts.set(url, text);
    return url;
  });
  const main = texts.get(urls.get("main.js"));
  assert.ok(main.includes(`from "${urls.get("draw/a.js")}"`));
  assert.ok(main.includes(`from "${urls.get("b.js")}"`));
  assert.ok(texts.get(urls.get("b.js")).includes('import("./types.js")'));
});

test("a circle and a missing module are errors", () => {
  assert.throws(() => inOrder({ "a.js": 'import "./b.js"', "b.js": 'import "./a.js"' }, "a.js"), /circle/);
  assert.throws(() => inOrder({ "a.js": 'import "./b.js"' }, "a.js"), /no module b\.js/);
});

test("the frame has the styles and starts the page", () => {
  const text = frameDocument(FILES, "blob:7");
  assert.ok(text.includes("<style>main { color: red }</style>"));
  assert.ok(text.includes('from "blob:7"') && !text.includes("page.js"));
});
