"""Frames of a drag in Chromium: from the event of the mouse to the painted canvas.

A chain of rectangles, corner to corner: coincident ends, horizontal and vertical sides, a width
each; the heights are free. The corner at one end is dragged in a circle, so that the whole chain
deforms. Each move of the mouse is dispatched in the page and followed by the next one as soon as
its frame is on the canvas, at most one per `PERIOD`; reading a pixel back forces the rasterisation.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Dimension
from arael.sketch.document.saved import save
from benchmarks.measure import table
from benchmarks.systems import Plan

PER_RECTANGLE = 10
PERIOD = 8.0
"""Milliseconds between moves of the mouse: 125 a second."""
WANTED = {500: "p99 4 ms", 10_000: "p95 16.7 ms"}

_DRAG = """async ([handle, moves, period]) => {
  const canvas = app.canvas, rect = canvas.getBoundingClientRect();
  const [x0, y0] = app.view.toScreen(app.store.point(handle));
  const send = (type, x, y) => canvas.dispatchEvent(new PointerEvent(type, {
    clientX: rect.left + x, clientY: rect.top + y, pointerId: 1, button: 0, isPrimary: true,
    pointerType: "mouse", bubbles: true, buttons: type === "pointerup" ? 0 : 1}));
  const pixel = app.renderer.moving.ctx;
  const found = {total: [], paint: []};
  const paint = app.renderer.paint.bind(app.renderer);
  app.renderer.paint = () => {
    const began = performance.now();
    paint();
    pixel.getImageData(0, 0, 1, 1);
    found.paint.push(performance.now() - began);
  };
  const step = (x, y) => new Promise((resolve) => {
    const began = performance.now();
    const ended = setTimeout(() => finish(NaN), 2000);
    const finish = (now) => {
      clearTimeout(ended);
      app.wire.removeEventListener("frame", frame);
      found.total.push(Number.isNaN(now) ? 2000 : now - began);
      setTimeout(resolve, Math.max(period - (now - began), 0));
    };
    const frame = () => {
      // drawn as it came, or by the next refresh of the screen
      const done = () => {
        pixel.getImageData(0, 0, 1, 1);
        finish(performance.now());
      };
      if (app.renderer.pending) app.renderer.addEventListener("painted", done, {once: true});
      else done();
    };
    app.wire.addEventListener("frame", frame);
    send("pointermove", x, y);
  });
  send("pointermove", x0, y0);
  send("pointerdown", x0, y0);
  send("pointermove", x0 + 10, y0);
  await new Promise((resolve) => setTimeout(resolve, 1500));
  for (let i = 1; i <= moves; i++) {
    const a = i / 25;
    await step(x0 + 10 + 60 * Math.sin(a), y0 + 30 * (1 - Math.cos(a)));
  }
  const moved = app.renderer.movedCount;
  send("pointerup", x0 + 10, y0);
  return {...found, moved};
}"""


def chain(count: int) -> Document:
    """A chain of rectangles with about `count` constraints."""
    document = Document()
    with document.transaction("chain"):
        for i in range(max(count // PER_RECTANGLE, 1)):
            _rectangle(document, i)
    return document


def _rectangle(document: Document, i: int) -> None:
    w, h = 6.0 + i % 3, 4.0 + i % 4
    # rows of fifty, so that the drawing is about as high as wide
    x, y = document.numbers_of(f"L{4 * i - 2}")[:2] if i else (0.0, 0.0)
    up = 1.0 if (i // 40) % 2 == 0 else -1.0
    corners = [(x, y), (x + w, y), (x + w, y + up * h), (x, y + up * h)]
    names = [f"L{4 * i + k}" for k in range(4)]
    for k, name in enumerate(names):
        ends = (*corners[k], *corners[(k + 1) % 4])
        document.add_entity("line", ends, name=name)
    pairs = [(f"{names[k]}.p2", f"{names[(k + 1) % 4]}.p1") for k in range(4)]
    if i:
        pairs.append((f"{names[0]}.p1", f"L{4 * i - 2}.p1"))
    for k, pair in enumerate(pairs):
        document.put("constraints", Constraint(f"C{5 * i + k}", "coincident", pair))
    for k, name in enumerate(names):
        kind = ("horizontal", "vertical")[k % 2]
        own = f"C{name}{kind[0].upper()}"
        document.put("constraints", Constraint(own, kind, (name,)))
    document.put("dimensions", Dimension(f"d{i}", "length", (names[0],), Amount(f"{w:g}", w)))


@contextmanager
def _page(file: Path) -> Iterator[Any]:
    """The editor on a file in Chromium."""
    from playwright.sync_api import sync_playwright

    from tests.sketch.server.process import ServerProcess

    chromium = os.environ.get("ARAEL_CHROMIUM") or shutil.which("chromium")
    with ServerProcess(file, folder=file.parent) as server, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(server.address)
        # the page's policy forbids `wait_for_function`
        for _ in range(300):
            if page.evaluate("!!window.app && app.store.verdict.revision > 0"):
                break
            page.wait_for_timeout(100)
        page.wait_for_timeout(500)
        yield page
        browser.close()


def frames(count: int, moves: int) -> dict[str, Any]:
    """Milliseconds of each frame of a drag, by part."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "chain.json"
        save(chain(count), file)
        last = 4 * (count // PER_RECTANGLE - 1) + 2
        with _page(file) as page:
            found: dict[str, Any] = page.evaluate(_DRAG, [f"L{last}.p1", moves, PERIOD])
    return found


def run(plan: Plan, picture: Path | None) -> list[str]:
    """The chapter of a report."""
    del picture
    moves = 60 if plan.quick else 600
    rows = []
    for count, wanted in WANTED.items():
        found = frames(count, moves)
        total, paint = np.array(found["total"]), np.array(found["paint"])
        p50, p95, p99 = np.percentile(total, [50, 95, 99])
        dropped = int((total > 16.7).sum())
        rows.append(
            [
                f"{count:,}",
                str(found["moved"]),
                *(f"{x:.1f}" for x in (p50, p95, p99, total.max())),
                f"{np.median(paint):.1f}",
                f"{dropped} of {len(total)}",
                wanted,
            ]
        )
    head = ["constraints", "entities that move", "p50", "p95", "p99", "most", "painting, p50"]
    head += ["later than 16.7 ms", "wanted"]
    return [
        "## sketch-frames",
        "",
        "From the event of the mouse to the painted canvas, milliseconds, in Chromium; the server",
        "is a process on the same machine.",
        "",
        *table(head, rows),
    ]


if __name__ == "__main__":
    print(json.dumps({str(count): frames(count, 100) for count in WANTED}))
