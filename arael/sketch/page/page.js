/** Entry point of index.html. */

import { start } from "./main.js";
import { webSocket } from "./transport.js";
import { randomId } from "./wire.js";

const app = start(document.body, webSocket(window.location, randomId()));
// for the console and for tests in a browser
Object.assign(window, { app });
