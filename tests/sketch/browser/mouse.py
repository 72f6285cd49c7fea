"""Mouse and tools, at places of the sketch."""

from __future__ import annotations

from typing import Any

GROUND = """((canvas) => {
    const read = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    read.drawImage(canvas, 0, 0);
    return read;
})(document.querySelector("#ground"))"""
"""A context to read pixels of what rests from: the canvas on the screen shows an image."""


def at(page: Any, x: float, y: float) -> tuple[float, float]:
    """Where a point of the sketch is in the window."""
    found = page.evaluate(
        """([x, y]) => {
            const [u, v] = app.view.toScreen([x, y]);
            const box = app.canvas.getBoundingClientRect();
            return [box.left + u, box.top + v];
        }""",
        [x, y],
    )
    return found[0], found[1]


def click(page: Any, x: float, y: float, **options: Any) -> None:
    """Move to a place and click there."""
    page.mouse.move(*at(page, x, y))
    page.mouse.click(*at(page, x, y), **options)


def drag(page: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Press, move in steps, release; what moves does so later, wait for it."""
    page.mouse.move(*at(page, *start))
    page.mouse.down()
    page.mouse.move(*at(page, *end), steps=8)
    page.mouse.up()


def start(page: Any, tool: str) -> None:
    """Take a tool; its key and its button have tests of their own."""
    page.evaluate("tool => app.tools.start(tool)", tool)
