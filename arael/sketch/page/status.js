/** The line at the bottom: what to do next, the cursor, grid and unit; connection, busy, windows. */

import { permissionsBar } from "./agent.js";
import { shown } from "./amounts.js";
import { fill, h, later, once, seldom } from "./dom.js";
import { icon } from "./icons.js";

/** Milliseconds between coordinates of the pointer. */
const PERIOD = 80;
/** Milliseconds after which it rests: in a drag they are shown then, since to put in another text takes the page 3 ms. */
const RESTS = 120;

/** @param {import("./app.js").App} app @param {HTMLElement} element */
export function mountStatus(app, element) {
  const { store, view, wire } = app;
  const hint = h("span", { class: "status-hint", role: "status" });
  const values = h("span", { class: "status-values" });
  const busy = h("span", { class: "status-busy", hidden: true });
  const place = h("span", { class: "status-place" });
  const scale = h("span", { class: "status-scale" });
  const others = h("span", { class: "status-others" });
  const link = h("span", { class: "status-link", role: "status" });
  fill(element, hint, values, busy, place, scale, permissionsBar(app), others, link);

  app.addEventListener("hint", (event) => {
    fill(hint, /** @type {CustomEvent} */ (event).detail);
    // without a keyboard a value is typed after a tap
    const { current } = app.tools;
    const fields = current.begun ? current.fields() : [];
    fill(values, ...fields.map(({ title }, i) => h("button", { class: "button", onclick: () => app.tools.express("", i) }, title)));
  });
  const showPlace = () => {
    const at = app.tools.current.place?.at;
    const { factor } = store.lengths;
    const digits = Math.max(0, Math.min(9, Math.ceil(Math.log10(view.scale / factor))));
    place.textContent = at ? at.map((x) => (x * factor).toFixed(digits)).join(", ") : "";
  };
  const soon = seldom(PERIOD, showPlace);
  const rests = later(RESTS, showPlace);
  app.canvas.addEventListener("pointermove", () => (app.drag.active ? rests : soon)());
  const showScale = once(() => {
    const { name, other, factor } = store.lengths;
    const unit = other ? `${name} (the part: ${store.unit})` : name;
    scale.textContent = view.grid ? `grid ${shown(view.gridStep() * factor)} ${unit}` : unit;
  });
  view.addEventListener("change", showScale);
  store.addEventListener("change", showScale);

  store.addEventListener("status", (event) => {
    const message = /** @type {CustomEvent} */ (event).detail;
    if (message.type === "hello") showScale();
    if (message.type === "busy") {
      const stop = h("button", { class: "button", onclick: () => wire.breakOff() }, "Break off");
      fill(busy, h("span", { class: "spinner", "aria-hidden": "true" }), `solving${message.what ? `: ${message.what}` : ""}`, stop);
      busy.hidden = false;
    }
    if (message.type === "idle") busy.hidden = true;
    if (message.type === "presence") {
      const { windows, agents } = message;
      const texts = [windows > 1 ? `${windows} windows` : "", agents ? `${agents} agent${agents === 1 ? "" : "s"}` : ""];
      others.textContent = texts.filter(Boolean).join(", ");
    }
  });

  let was = "";
  function connection() {
    const open = wire.state === "open";
    link.dataset.state = wire.state;
    fill(link, icon(open ? "check" : "warning"), open ? "connected" : "not connected");
    app.root.dataset.link = wire.state;
    if (!open && was === "open") {
      busy.hidden = true;
      lost(app);
    } else if (open) {
      const back = app.root.querySelector('[data-key="link"]') !== null;
      app.notes?.close("link");
      if (back) app.notes?.show({ level: "info", text: "Connected again" });
    }
    was = wire.state;
  }
  wire.addEventListener("state", connection);
  connection();
  showScale();
}

const KNOCK = 3000;

/** The connection is lost: report it, and whether a server answers that does not know this page. @param {import("./app.js").App} app */
function lost(app) {
  const show = (/** @type {string} */ text, /** @type {string} */ hint) =>
    app.notes?.show({ level: "warning", key: "link", stays: true, text, hint });
  show(
    "The connection to the server is lost",
    "The page connects again by itself. Until then the drawing cannot be changed.",
  );
  const knock = async () => {
    if (app.wire.state === "open") return;
    const answers = await fetch("./index.html", { method: "HEAD", cache: "no-store" }).then(
      (response) => response.ok,
      () => false,
    );
    // it may have connected meanwhile
    setTimeout(() => {
      if (app.wire.state === "open") return;
      if (answers) show("The server was started again under another address", "Open the address that it has printed.");
      else setTimeout(knock, KNOCK);
    }, KNOCK);
  };
  setTimeout(knock, KNOCK);
}
