"""Pictures of the sketch editor in the documents and in README.md.

Run ``python docs/figures/sketch/pictures.py``. It needs the extra ``serve``, playwright for Python
and Chromium (``ARAEL_CHROMIUM`` names another one than the first on the path).
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from arael.sketch import Sketch
from arael.sketch.exchange import write

FOLDER = Path(__file__).parent
ADDRESS = re.compile(r"open (http://127\.0\.0\.1:\d+/\?token=\S+)")

PART = [
    "param width 60",
    "param height width / 2",
    "add_rect 0,0 54,26 hv",
    "lock L0.p1 0,0",
    "length L0 width",
    "length L1 height",
    "add_circle 15,12 6",
    "fillet L1.p2 5",
]
REST = [
    "radius A0 height / 5",
    "hdistance L0.p1 A0.center height / 2",
    "vdistance L0.p1 A0.center height / 2",
]


def sheet() -> None:
    """The part on a sheet for the shop."""
    sketch = Sketch()
    for line in [*PART, *REST]:
        sketch.run(line)
    write(sketch.document, FOLDER / "sheet.png", sheet="A4", title="Plate", date="2026-01-31")


def main() -> None:
    """Draw the part, with a picture of each stage."""
    sheet()
    browser_path = os.environ.get("ARAEL_CHROMIUM") or shutil.which("chromium")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        command = [sys.executable, "-m", "arael", "sketch", "--serve", "plate.json", "--no-open"]
        server = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
        try:
            assert server.stdout is not None
            found = next(match for line in server.stdout if (match := ADDRESS.search(line)))
            browser = playwright.chromium.launch(
                executable_path=browser_path, args=["--no-sandbox"]
            )
            stages(browser, found[1])
            browser.close()
        finally:
            server.terminate()
            server.wait()


def window(browser: Any, address: str, **options: Any) -> Any:
    """A page that is connected; without the tour."""
    context = browser.new_context(**{"viewport": {"width": 1280, "height": 800}, **options})
    context.add_init_script("localStorage.setItem('arael-sketch-tour', 'seen')")
    page = context.new_page()
    page.goto(address)
    while not page.evaluate("app.wire.state === 'open' && app.store.revision > 0"):
        page.wait_for_timeout(50)
    return page


def run(page: Any, lines: list[str]) -> None:
    """Run commands; each has to succeed."""
    for line in lines:
        reply = page.evaluate("text => app.wire.run(text)", line)
        assert reply["ok"], f"{line}: {reply['text']}"


def shoot(page: Any, name: str) -> None:
    """Keep a picture when everything has come to rest."""
    page.wait_for_timeout(600)
    page.screenshot(path=FOLDER / f"{name}.png")


def stages(browser: Any, address: str) -> None:
    """All pictures."""
    page = window(browser, address)
    page.evaluate("app.canvas.focus()")
    page.keyboard.press("r")
    for key, count in (("Enter", 1), ("ArrowRight", 15), ("ArrowUp", 7)):
        for _ in range(count):
            page.keyboard.press(key)
    shoot(page, "drawing")
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    run(page, PART)
    page.evaluate("() => { app.fit(); app.store.select([]); app.panels.show('freedom'); }")
    shoot(page, "free")
    page.evaluate("() => { app.panels.show('selection'); app.store.select(['L2']); }")
    where = page.evaluate("app.view.toScreen([42, 30])")
    box = page.locator("#canvas").bounding_box()
    page.mouse.click(box["x"] + where[0], box["y"] + where[1], button="right")
    shoot(page, "marks")
    page.keyboard.press("Escape")
    page.evaluate("app.store.select([])")
    page.evaluate("() => { app.panels.show('parameters'); app.typing.edit('d1'); }")
    page.locator("#typed").fill("width / 2 + 4 mm")
    shoot(page, "typing")
    page.keyboard.press("Escape")
    page.evaluate("() => { app.panels.show('relations'); app.run('length L2 70'); }")
    shoot(page, "refused")
    page.evaluate("() => app.notes.close('refused')")
    run(page, REST)
    page.evaluate("() => { app.fit(); app.panels.show('relations'); }")
    shoot(page, "defined")
    page.evaluate("app.theme.set('dark')")
    page.evaluate("app.store.select(['A0'])")
    page.evaluate("app.panels.show('selection')")
    shoot(page, "dark")
    phone = {"viewport": {"width": 390, "height": 844}, "is_mobile": True, "has_touch": True}
    small = window(browser, address, **phone)
    small.evaluate("() => { app.fit(); app.store.select(['A0']); }")
    shoot(small, "phone")


if __name__ == "__main__":
    main()
