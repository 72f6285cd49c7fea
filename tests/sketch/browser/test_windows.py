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
STATE = f"JSON.stringify([app.store.revision, app.store.history.done, {SHOWN}])"


def same(first: Any, second: Any, *, seconds: float = 15.0) -> None:
    """Wait until both windows show the same revision: each gets a change in its own message."""
    for _ in range(int(seconds * 20)):
        states = [page.evaluate(STATE) for page in (first, second)]
        if states[0] == states[1]:
            return
        first.wait_for_timeout(50)
    raise AssertionError(f"not the same within {seconds:g} s: {states}")


def shows(page: Any, state: str) -> None:
    """Wait until a window shows what another one did, or it did before."""
    wait(page, f"{SHOWN} === {json.dumps(state)}")


def test_a_reload_shows_the_same_document(editor: Any) -> None:
    page = connected(editor.page)
    run(page, RECTANGLE, "length L0 40")
    before = page.evaluate(SHOWN)
    page.reload()
    shows(connected(page), before)


def test_two_windows_stay_in_step_and_keep_their_own_selection(editor: Any) -> None:
    first, second = connected(editor.page), connected(editor.open())
    run(first, RECTANGLE)
    wait(second, "app.store.entities.size === 4")
    run(second, "length L0 25")
    same(first, second)
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
        shows(page, before)
        run(page, "length L1 10")
        wait(page, "app.store.dimensions.size === 2")
        assert names(page, "dimensions") == ["d0", "d1"]
        page.reload()
        wait(connected(page), "app.store.dimensions.size === 2")
        editor.close()
