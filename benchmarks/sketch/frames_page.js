// Runs in the page: takes the time of every stage of the frames of a drag, and moves the mouse.

/** Milliseconds that a frame may take before the next move of the mouse is sent all the same. */
const LATEST = 2000;

/**
 * Take times from now on.
 * @returns {Map<number, object>} records by the sequence of the place of the pointer
 */
function recorded() {
  const { wire, store, renderer } = app;
  const records = new Map();
  /** Records of frames that are not on the canvas yet. */
  let open = [];
  let event = { stamp: 0, heard: 0 };
  const hear = (one) => {
    // the first to come of the events of one move counts
    if (one.buttons && one.timeStamp > event.stamp) event = { stamp: one.timeStamp, heard: performance.now() };
  };
  for (const type of ["pointerrawupdate", "pointermove"]) window.addEventListener(type, hear, true);

  const send = wire._send.bind(wire);
  wire._send = (buffer) => {
    const [kind, sequence] = new Uint32Array(buffer, 0, 2);
    if (kind === 3) records.set(sequence, { ...event, send: performance.now() });
    send(buffer);
  };
  const flush = () => {
    if (!open.length) return;
    // reading a pixel forces what was recorded to be rasterised
    renderer.moving.getImageData(0, 0, 1, 1);
    const flushed = performance.now();
    for (const one of open) one.flushed = flushed;
    open = [];
    wire.dispatchEvent(new Event("flushed"));
  };
  const receive = wire._receive.bind(wire);
  wire._receive = (buffer) => {
    const [kind, sequence, count] = new Uint32Array(buffer, 0, 3);
    const record = kind === 2 ? records.get(sequence) : undefined;
    if (record && !record.received) {
      Object.assign(record, { received: performance.now(), numbers: count });
      open.push(record);
    }
    receive(buffer);
    // a frame in which nothing moved is not painted
    if (!count || !renderer.pending) flush();
  };
  const frame = store.frame.bind(store);
  store.frame = (...given) => {
    const decoded = performance.now();
    for (const one of open) one.decoded ??= decoded;
    frame(...given);
  };
  const paint = renderer.paint.bind(renderer);
  renderer.paint = () => {
    const painting = performance.now();
    paint();
    const painted = performance.now();
    for (const one of open) Object.assign(one, { painting, painted });
    flush();
  };
  return records;
}

/** Places of the pointer on ellipses, in pixels of the window, from where a point is; `up`: above it. */
function places(handle, moves, up) {
  const { left, top } = app.canvas.getBoundingClientRect();
  const [x, y] = app.view.toScreen(app.store.point(handle));
  const found = [[left + x, top + y], [left + x + 10, top + y]];
  for (let i = 1; i <= moves; i++) {
    const a = i / 25;
    found.push([left + x + 10 + 60 * Math.sin(a), top + y + (up ? -30 : 30) * (1 - Math.cos(a))]);
  }
  return found;
}

const later = (millis) => new Promise((resolve) => setTimeout(resolve, millis));

/** Moves dispatched in the page, each after the frame of the one before, at most one per `period`. */
async function dispatched(handle, moves, up, period) {
  const send = (type, [x, y]) => app.canvas.dispatchEvent(new PointerEvent(type, {
    clientX: x, clientY: y, pointerId: 1, button: 0, isPrimary: true, pointerType: "mouse",
    bubbles: true, buttons: type === "pointerup" ? 0 : 1,
  }));
  const [from, second, ...rest] = places(handle, moves, up);
  send("pointermove", from);
  send("pointerdown", from);
  send("pointermove", second);
  await later(1500);
  taken.clear();
  for (const at of rest) {
    const began = performance.now();
    await new Promise((resolve) => {
      const late = setTimeout(resolve, LATEST);
      app.wire.addEventListener("flushed", () => (clearTimeout(late), resolve()), { once: true });
      send("pointermove", at);
    });
    await later(Math.max(period - (performance.now() - began), 0));
  }
  const moved = app.renderer.movedCount;
  send("pointerup", second);
  return { records: [...taken], moved };
}
