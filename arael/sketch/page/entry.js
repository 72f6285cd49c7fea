/** A plain field over the canvas for a typed value; the panels put a richer one in its place. */

/** @typedef {import("./app.js").TypingRequest} TypingRequest */

export class Entry {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    /** @type {HTMLInputElement|null} */
    this.input = null;
  }

  /** @param {TypingRequest} request */
  open(request) {
    this.close();
    const input = document.createElement("input");
    this.input = input;
    input.value = request.text;
    input.setAttribute("aria-label", request.title);
    input.className = "entry";
    input.style.left = `${request.at[0]}px`;
    input.style.top = `${request.at[1]}px`;
    input.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key === "Enter") void this._commit(request, input);
      if (event.key === "Escape") {
        this.close();
        request.cancel?.();
      }
    });
    this.app.canvas.append(input);
    input.focus();
    input.select();
  }

  /** @param {TypingRequest} request @param {HTMLInputElement} input */
  async _commit(request, input) {
    const reply = await request.commit(input.value);
    if (reply.ok) return this.close();
    input.setAttribute("aria-invalid", "true");
    input.title = reply.error?.message ?? reply.text;
  }

  close() {
    this.input?.remove();
    this.input = null;
    this.app.canvas.focus();
  }
}
