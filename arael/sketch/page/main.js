/** Puts the parts together; `page.js` starts it in a browser, a notebook by its own transport. */

import { App } from "./app.js";
import { mountPanels } from "./panels/index.js";

/**
 * @param {HTMLElement} root
 * @param {import("./transport.js").Connect} connect
 * @returns {App}
 */
export function start(root, connect) {
  const app = new App(root, connect);
  mountPanels(app);
  app.start();
  return app;
}
