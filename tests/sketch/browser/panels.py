"""What tests of the panels do with a page."""

from __future__ import annotations

import math
from typing import Any

RECTANGLE = "add_rect 0,0 40,20 hv"


def run(page: Any, *lines: str) -> None:
    """Run commands as the page does."""
    for line in lines:
        reply = page.evaluate("text => app.wire.run(text)", line)
        assert reply["ok"], f"{line}: {reply['text']}"


def wait(page: Any, expression: str, *, seconds: float = 15.0) -> Any:
    """Wait until an expression of the page is true; its policy forbids `wait_for_function`."""
    for _ in range(int(seconds * 20)):
        found = page.evaluate(expression)
        if found:
            return found
        page.wait_for_timeout(50)
    raise AssertionError(f"not within {seconds:g} s: {expression}")


def connected(page: Any) -> Any:
    """Wait until the page shows the document."""
    ready = "!!(window.app && app.wire.state === 'open' && app.store.revision > 0)"
    wait(page, f"{ready} && app.store.verdict.revision > 0")
    return page


def names(page: Any, table: str) -> list[str]:
    """Names of the records of a table."""
    found: list[str] = page.evaluate("table => [...app.store[table].keys()]", table)
    return found


def press(page: Any, *keys: str) -> None:
    """Press keys, one after the other; `ArrowUp*5` five times."""
    for key in keys:
        name, _, count = key.partition("*")
        for _ in range(int(count or 1)):
            page.keyboard.press(name)


def length(page: Any, name: str) -> float:
    """Length of a line as it is shown."""
    x1, y1, x2, y2 = page.evaluate("name => [...app.store.numbers(name)]", name)
    return math.hypot(x2 - x1, y2 - y1)
