/** Everything around the canvas, put in its place. */

import { Actions } from "../actions.js";
import { askForAgents } from "../agent.js";
import { part } from "../dom.js";
import { Field } from "../field.js";
import { Files } from "../files.js";
import { Help } from "../help.js";
import { Keys } from "../keys.js";
import { Notes } from "../notes.js";
import { mountPalette } from "../palette.js";
import { mountStatus } from "../status.js";
import { Theme } from "../theme.js";
import { mountTop } from "../top.js";
import { Tour } from "../tour.js";
import { Typing } from "../typing.js";
import { Dock } from "./dock.js";

/**
 * @param {import("../app.js").App} app
 */
export function mountPanels(app) {
  const { root } = app;
  root.classList.add("editor");
  const stage = part(root, "#stage");
  app.theme = new Theme(root.ownerDocument.documentElement);
  app.actions = new Actions(app);
  app.notes = new Notes(app, stage);
  app.typing = new Typing(app, stage);
  app.field = new Field(app, part(root, "#field"));
  app.files = new Files(app);
  app.help = new Help(app);
  app.tour = new Tour(app);
  app.panels = new Dock(app, part(root, "#right"), part(root, "#bottom"));
  app.panels.show(app.panels.open);
  app.keys = new Keys(app);
  mountTop(app, part(root, "#top"));
  mountPalette(app, part(root, "#left"));
  mountStatus(app, part(root, "#status"));
  askForAgents(app);
  app.tour.first();
}
