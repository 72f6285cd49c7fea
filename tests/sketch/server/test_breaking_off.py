"""A verdict that a person breaks off: nothing changes, and the next one is right."""

from __future__ import annotations

from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from arael.sketch.judge.judge import Judge
from arael.sketch.server.shared import SharedSketch
from tests.sketch.server.shared import Local, chain, shared_sketch


@pytest.fixture
def shared(tmp_path: Path) -> SharedSketch:
    return shared_sketch(chain(tmp_path / "chain.json", 400))


@pytest.fixture
def page(shared: SharedSketch) -> Local:
    return Local(shared)


def break_at(monkeypatch: pytest.MonkeyPatch, shared: SharedSketch, looks: int) -> None:
    """Have another thread break the verdict off when its first factor begins.

    With `looks`, after so many looks of the compiled loops at the flag.
    """
    original = Judge._rank
    solver = shared.session.editor.solver

    def interrupted(self: Judge, *args: Any, **more: Any) -> Any:
        other = Thread(target=shared.interrupt)
        other.start()
        other.join()
        if looks:
            solver.interruption.withdraw()
            solver.interruption.request(looks)
        return original(self, *args, **more)

    monkeypatch.setattr(Judge, "_rank", interrupted)


@pytest.mark.parametrize("looks", [0, 1, 300, 1000, 1700])
def test_a_verdict_that_is_broken_off_leaves_everything_as_it_was(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch, looks: int
) -> None:
    shared.idle()
    before = page.verdict
    page.run("length L0 20")
    document = shared.session.document
    values, revision = document.values.tobytes(), shared.revision
    steps = len(document.history.done)
    with monkeypatch.context() as patch:
        break_at(patch, shared, looks)
        assert shared.idle() == 0.0
    assert page.verdict is before
    assert page.last("message")["text"].startswith("broken off")
    assert page.last("message")["level"] == "info"
    assert document.values.tobytes() == values and shared.revision == revision
    assert len(document.history.done) == steps and page.is_in_step()
    shared.resume()
    shared.idle()  # it is not begun again by itself
    assert page.verdict is before
    page.run("dof")
    shared.idle()
    found = dict(page.verdict)
    other = Local(shared, "w2")
    shared.idle()
    assert found == other.verdict
    assert found["freedoms"] == before["freedoms"] - 1


def test_the_request_ends_with_the_verdict(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        break_at(patch, shared, 0)
        shared.idle()
    solver = shared.session.editor.solver
    assert not solver.interruption.requested
    solver.interrupt()  # nothing is in progress
    assert not solver.interruption.requested


def test_a_question_for_conflicts_is_broken_off(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        break_at(patch, shared, 0)
        assert page.ask("ask", what="conflicts")["error"]["code"] == "E1235"
    assert page.ask("ask", what="conflicts")["data"]["conflicts"] == []


@pytest.mark.parametrize("looks", [0, 300])
@pytest.mark.parametrize("command", ["dof", "dof analyze", "free", "what_if horizontal L9"])
def test_a_command_that_asks_is_broken_off(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch, command: str, looks: int
) -> None:
    document = shared.session.document
    values, steps = document.values.tobytes(), len(document.history.done)
    page.run("param w 3")  # so that nothing is known yet
    with monkeypatch.context() as patch:
        break_at(patch, shared, looks)
        assert page.run(command)["error"]["code"] == "E1235"
    shared.resume()
    assert not shared.session.editor.solver.interruption.requested
    assert document.values.tobytes() == values and len(document.history.done) == steps + 1
    assert page.run(command)["ok"]


def test_an_edit_is_broken_off_in_its_verdict(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch
) -> None:
    page.run("length L0 20")
    document = shared.session.document
    values, dimensions = document.values.tobytes(), list(document.dimensions)
    with monkeypatch.context() as patch:
        break_at(patch, shared, 0)
        reply = page.run("length L1 20")
    assert reply["error"]["code"] == "E1235"
    shared.resume()
    assert document.values.tobytes() == values and list(document.dimensions) == dimensions
    assert page.is_in_step()
    assert page.run("length L1 20")["error"]["code"] == "E1230"
