"""Reload, several windows, and a server that dies and comes back."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from typing import Any

import pytest

from tests import optional
from tests.sketch.browser.conftest import Editor
from tests.sketch.browser.panels import RECTANGLE, connected, length, names, run, wait
from tests.sketch.server.process import ServerProcess

SHOWN = "JSON.stringify([...app.store.entities.keys()].map((n) => [n, ...app.store.numbers(n)]))"


def same(first: Any, second: Any) -> None:
    """Wait until both windows show the same numbers: each gets a change in a message of its own."""
    wait(first, f"{SHOWN} === {json.dumps(second.evaluate(SHOWN))}")


def test_a_reload_shows_the_same_document(editor: Any) -> None:
    page = connected(editor.page)
    run(page, RECTANGLE, "length L0 40")
    before = page.evaluate(SHOWN)
    page.reload()
    assert connected(page).evaluate(SHOWN) == before


def test_two_windows_stay_in_step_and_keep_their_own_selection(editor: Any) -> None:
    first, second = connected(editor.page), connected(editor.open())
    run(first, RECTANGLE)
    wait(second, "app.store.entities.size === 4")
    run(second, "length L0 25")
    wait(first, "app.store.dimensions.size === 1")
    assert length(first, "L0") == pytest.approx(25.0)
    first.evaluate("app.store.select(['L0'])")
    assert second.evaluate("app.store.selection.size") == 0
    wait(first, "document.querySelector('.status-others').textContent === '2 windows'")
    first.keyboard.press("Control+z")
    for page in (first, second):
        wait(page, "app.store.dimensions.size === 0")
    same(first, second)


def test_a_window_that_lost_its_connection_catches_up(editor: Any) -> None:
    first, second = connected(editor.page), connected(editor.open())
    first.evaluate("app.wire._connection.close()")
    wait(first, "app.wire.state === 'lost'")
    run(second, RECTANGLE)
    wait(first, "app.wire.state === 'open' && app.store.entities.size === 4")
    same(first, second)


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def test_a_server_that_dies_and_comes_back_has_lost_nothing(
    browser: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    optional.require("starlette")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    file, port = tmp_path / "sketch.json", str(free_port())
    first = ServerProcess(file, "--port", port, folder=tmp_path)
    with first:
        editor = Editor(browser, first)
        page = connected(editor.page)
        run(page, RECTANGLE, "length L0 40")
        before = page.evaluate(SHOWN)
        first.kill()
        page.get_by_text("The connection to the server is lost").wait_for()
        assert page.locator(".status-link").inner_text() == "not connected"
        reply = page.evaluate("app.wire.run('delete L0')")
        assert not reply["ok"]
        assert "was not run" in reply["text"]
    with ServerProcess(file, "--port", port, folder=tmp_path) as second:
        assert second.token == first.token
        page.get_by_text("Connected again").wait_for()
        wait(page, "app.wire.state === 'open' && app.store.entities.size === 4")
        assert page.evaluate(SHOWN) == before
        run(page, "length L1 10")
        assert names(page, "dimensions") == ["d0", "d1"]
        editor.close()
