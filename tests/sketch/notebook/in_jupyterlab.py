"""The editor in JupyterLab, tried by hand: no test, as JupyterLab is not needed otherwise.

    pip install jupyterlab playwright "arael[notebook]"
    python -m tests.sketch.notebook.in_jupyterlab [FOLDER FOR PICTURES]

It starts JupyterLab, runs a notebook in Chromium, draws in the editor of its second output, and
checks that the sketch of the kernel follows, and that the editor follows what a later cell does.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

from playwright.sync_api import TimeoutError, sync_playwright

from tests.sketch.browser.conftest import chromium

CELLS = [
    'from arael.sketch import Sketch\ns = Sketch()\ns.run("add_rect 0,0 40,20 hv")\ns',
    "s.edit()",
    'print("entities:", len(s.entities))',
    's.run("length L0 55")\nprint("width:", s.run("print L0.length"))',
]
STARTED_WITHIN = 60.0


def notebook(folder: Path) -> Path:
    """A notebook of the cells, none of which has been run."""
    cells = [
        {
            "cell_type": "code",
            "id": f"cell{i}",
            "source": text,
            "metadata": {},
            "outputs": [],
            "execution_count": None,
        }
        for i, text in enumerate(CELLS)
    ]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    path = folder / "part.ipynb"
    content = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4}
    path.write_text(json.dumps({**content, "nbformat_minor": 5}), encoding="utf-8")
    return path


def served(folder: Path) -> tuple[subprocess.Popen[bytes], str]:
    """JupyterLab in a folder, and its address; what it prints goes to `lab.log` there."""
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--port=0"]
    log = folder / "lab.log"
    with log.open("wb") as file:
        process = subprocess.Popen(
            [*command, f"--ServerApp.root_dir={folder}"], stdout=file, stderr=subprocess.STDOUT
        )
    end = time.monotonic() + STARTED_WITHIN
    while time.monotonic() < end:
        text = log.read_text("utf-8", errors="replace")
        found = re.search(r"http://127\.0\.0\.1:\d+/lab\?token=\w+", text)
        if found:
            return process, found[0]
        time.sleep(0.2)
    process.kill()
    raise SystemExit(f"JupyterLab did not start: see {log}")


def run_cell(page: Any, number: int) -> Any:
    """Run a cell and wait for its output."""
    cell = page.locator(".jp-Notebook .jp-CodeCell").nth(number)
    output = cell.locator(".jp-OutputArea-output").last
    for _ in range(6):  # a cell that is run before its kernel is ready is not run at all
        cell.locator(".cm-content").click()
        page.keyboard.press("Control+Enter")
        try:
            output.wait_for(timeout=10_000)
        except TimeoutError:
            continue
        break
    return cell


def tried(page: Any, pictures: Path) -> None:
    """Go through the cells."""
    page.locator(".jp-Notebook .jp-CodeCell").first.wait_for(timeout=60_000)
    page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for(timeout=60_000)
    shown = run_cell(page, 0)
    shown.locator("svg line, svg path, img").first.wait_for()
    editor = run_cell(page, 1)
    editor.locator("iframe").wait_for()
    frame = editor.locator("iframe").element_handle().content_frame()
    frame.wait_for_function("window.app?.store.entities.size === 4")
    editor.scroll_into_view_if_needed()
    frame.locator("#left [data-action=tool_circle]").click()
    box = frame.locator("#canvas").bounding_box()
    x, y = frame.evaluate("app.view.toScreen([12, 10])")
    radius = 5 * frame.evaluate("app.view.scale")
    page.mouse.click(box["x"] + x, box["y"] + y)
    page.mouse.move(box["x"] + x + radius, box["y"] + y, steps=4)
    page.mouse.click(box["x"] + x + radius, box["y"] + y)
    frame.wait_for_function("app.store.entities.size === 5")
    page.screenshot(path=pictures / "drawn.png")
    counted = run_cell(page, 2)
    assert "entities: 5" in counted.inner_text(), counted.inner_text()
    run_cell(page, 3)
    frame.wait_for_function(
        "Math.abs(app.store.numbers('L0')[2] - app.store.numbers('L0')[0] - 55) < 1e-6"
    )
    frame.wait_for_function("app.store.verdict.revision === app.store.revision")
    editor.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "followed.png")


def main() -> None:
    """Try it; pictures go to the folder that is named."""
    pictures = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="arael-lab-"))
    folder = Path(tempfile.mkdtemp(prefix="arael-notebook-"))
    path = notebook(folder)
    process, address = served(folder)
    errors: list[str] = []
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.on("pageerror", lambda error: errors.append(str(error)))
            page.goto(address.replace("/lab?", f"/lab/tree/{path.name}?"))
            try:
                tried(page, pictures)
            except BaseException:
                page.screenshot(path=pictures / "failed.png")
                raise
            finally:
                print("errors of the page:", errors or "none")
    finally:
        process.terminate()
        process.wait()
    names = ("jupyterlab", "ipykernel", "anywidget", "ipywidgets")
    print("worked with", ", ".join(f"{name} {version(name)}" for name in names))
    print("pictures in", pictures)


if __name__ == "__main__":
    main()
