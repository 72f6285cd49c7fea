"""Chromium on the editor: the fixture `editor` opens a page on a server of its own."""

from __future__ import annotations

import fnmatch
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests import optional
from tests.sketch.browser.exercised import RECORDED, RECORDER, UNRECORDED
from tests.sketch.browser.panels import connected
from tests.sketch.server.inside import InsideServer
from tests.sketch.server.process import ServerProcess


def chromium() -> str:
    """Path of the browser: ARAEL_CHROMIUM, or the distribution's; empty if there is none."""
    return os.environ.get("ARAEL_CHROMIUM") or shutil.which("chromium") or ""


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A browser for all tests of a process."""
    optional.require("starlette")
    optional.require("playwright")
    path = chromium()
    if not path:
        pytest.skip("needs Chromium: apt install chromium, or set ARAEL_CHROMIUM")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield found
        found.close()


class Editor:
    """A page on a server.

    Attributes
    ----------
    server : in a thread, or a process
    page : of playwright
    errors : messages of the page's console and exceptions; a test fails if there are any
    """

    def __init__(self, browser: Any, server: InsideServer | ServerProcess, **options: Any) -> None:
        self.browser = browser
        self.server = server
        self.errors: list[str] = []
        self.context = browser.new_context(
            **{"viewport": {"width": 1100, "height": 750}, **options}
        )
        # the tour of the first visit stands over the drawing
        self.context.add_init_script("localStorage.setItem('arael-sketch-tour', 'seen')")
        self.context.add_init_script(RECORDER)
        self.page = self.open()

    def open(self) -> Any:
        """Another window on the same server; it waits until the page is connected."""
        page = self.context.new_page()
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on(
            "console",
            lambda message: self.errors.append(message.text) if message.type == "error" else None,
        )
        page.goto(self.server.address)
        return page

    def exercised(self) -> set[str]:
        """What its pages have done since they were loaded, as `exercises` names it."""
        return {part for page in self.context.pages for part in page.evaluate(RECORDED)}

    def close(self) -> None:
        """Close all windows."""
        EXERCISED.update(self.exercised())
        self.context.close()


EXERCISED: set[str] = set()
"""What the pages of the test that runs have done."""


PASSED = pytest.StashKey[bool]()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Note that a test has passed: neither skipped nor failed."""
    yield
    item.stash[PASSED] = True


@pytest.fixture(autouse=True)
def _exercises_what_it_declares(request: pytest.FixtureRequest) -> Iterator[None]:
    """A test with parameters has done one of its parts, others all of them."""
    EXERCISED.clear()
    yield
    declared = getattr(request.function, "exercised", ())
    parts = [part for part in declared if part.split(":")[0] not in UNRECORDED]
    if not parts or not request.node.stash.get(PASSED, False):
        return
    missing = [part for part in parts if not fnmatch.filter(EXERCISED, part)]
    assert len(missing) < len(parts) if hasattr(request.node, "callspec") else not missing, missing


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[InsideServer]:
    """A server on a new file, `sketch.json`."""
    optional.require("starlette")
    monkeypatch.setenv("ARAEL_STATE_DIR", str(tmp_path / ".state"))
    with InsideServer(tmp_path / "sketch.json") as running:
        yield running


@pytest.fixture
def editor(browser: Any, server: InsideServer) -> Iterator[Editor]:
    """A page on a server of its own."""
    found = Editor(browser, server)
    yield found
    found.close()
    assert found.errors == []


@pytest.fixture(scope="module")
def desk(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    """A page that the tests of a module share, for `sheet`."""
    folder = tmp_path_factory.mktemp("desk")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ARAEL_STATE_DIR", str(folder / ".state"))
        with InsideServer(folder / "sketch.json") as running:
            found = Editor(browser, running)
            connected(found.page)
            yield found
            found.close()


EMPTIED = """async () => {
    for (const open of document.querySelectorAll("dialog")) open.close();
    for (const note of document.querySelectorAll(".note")) note.remove();
    for (const field of document.querySelectorAll("input:not([type=file])")) {
        if (field.value) field.value = "", field.dispatchEvent(new Event("input"));
    }
    app.typing.close();
    app.tools.start("select");
    app.tools.current.place = null;
    app.panels.show("");
    for (const part of Object.keys(app.shown)) app.show(part, part !== "glyphs");
    app.theme.set("auto");
    app.showLengths("mm");
    app.snapper.recent = [];
    app.pointer.bare = false;
    app.pointer._last.time = -Infinity;
    const reply = await app.wire.run("clear; settings unit mm");
    app.store.select([]);
    app.view.setGrid(true);
    app.view.scale = 10;
    app.view.centre([0, 0]);
    app.canvas.focus();
    exercised.clear();
    return reply.ok;
}"""


@pytest.fixture
def sheet(desk: Editor) -> Iterator[Any]:
    """An empty drawing, ten pixels to a millimetre; quicker than `editor`, but with a history."""
    desk.page.mouse.move(1, 1)
    assert desk.page.evaluate(EMPTIED)
    yield desk.page
    EXERCISED.update(desk.exercised())
    errors, desk.errors[:] = list(desk.errors), []
    assert errors == []
