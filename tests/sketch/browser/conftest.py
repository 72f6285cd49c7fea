"""Chromium on the editor: the fixture `editor` opens a page on a server of its own."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests import optional
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
    server : the process
    page : of playwright
    errors : messages of the page's console and exceptions; a test fails if there are any
    """

    def __init__(self, browser: Any, server: ServerProcess, **options: Any) -> None:
        self.browser = browser
        self.server = server
        self.errors: list[str] = []
        self.context = browser.new_context(
            **{"viewport": {"width": 1100, "height": 750}, **options}
        )
        # the tour of the first visit stands over the drawing
        self.context.add_init_script("localStorage.setItem('arael-sketch-tour', 'seen')")
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

    def close(self) -> None:
        """Close all windows."""
        self.context.close()


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server on a new file, `sketch.json`."""
    optional.require("starlette")
    with ServerProcess(tmp_path / "sketch.json", folder=tmp_path) as running:
        yield running


@pytest.fixture
def editor(browser: Any, server: ServerProcess) -> Iterator[Editor]:
    """A page on a server of its own."""
    found = Editor(browser, server)
    yield found
    found.close()
    assert found.errors == []
