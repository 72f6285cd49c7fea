"""The thread of the sketch: turns, merged places of the pointer, breaking off, mistakes."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from arael.sketch.server.protocol import DragTo
from arael.sketch.server.shared import SharedSketch
from arael.sketch.server.worker import Worker
from tests.sketch.server.shared import Local, shared_sketch


@pytest.fixture
def shared() -> SharedSketch:
    return shared_sketch()


@pytest.fixture
def worker(shared: SharedSketch) -> Iterator[Worker]:
    found = Worker(shared)
    found.start()
    yield found
    found.stop()


def opened(worker: Worker, name: str = "w1") -> Local:
    return worker.call(lambda: Local(worker.shared, name)).result(30)


def wait(worker: Worker) -> None:
    """Until everything that was put in line is done."""
    worker.call(lambda: None).result(30)


def held(worker: Worker) -> threading.Event:
    """Keep the thread busy until the event is set."""
    event, began = threading.Event(), threading.Event()
    worker.call(lambda: (began.set(), event.wait(30)))
    assert began.wait(30)
    return event


def test_messages_are_answered_in_turn(worker: Worker) -> None:
    page = opened(worker)
    for k in range(20):
        worker.receive(page.window, {"type": "run", "id": k, "text": f"add_point {k},0"})
    wait(worker)
    replies = [message for message in page.messages if message["type"] == "reply"]
    assert [reply["id"] for reply in replies] == list(range(20))
    assert page.is_in_step()


def test_of_several_places_the_newest_is_used(worker: Worker) -> None:
    page = opened(worker)
    worker.receive(page.window, {"type": "run", "id": 1, "text": "add_line 0,0 50,0"})
    worker.receive(page.window, {"type": "drag", "id": 2, "handles": ["L0.p2"], "at": [50.0, 0.0]})
    wait(worker)
    event = held(worker)
    for k in range(1, 50):
        worker.receive(page.window, DragTo(k, 50.0 + k, 0.0))
    event.set()
    wait(worker)
    assert page.frames == [49]
    assert page.numbers("L0")[2] == pytest.approx(99)
    worker.receive(page.window, DragTo(50, 51.0, 0.0))
    worker.receive(page.window, {"type": "drop", "id": 3})
    wait(worker)
    assert page.history["done"][-1] == "drag L0.p2"
    assert page.numbers("L0")[2] == pytest.approx(51)


def test_a_frame_that_was_cut_short_is_gone_on_with_by_the_worker(
    worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = opened(worker)
    worker.receive(page.window, {"type": "run", "id": 1, "text": "add_line 0,0 50,0"})
    worker.receive(page.window, {"type": "drag", "id": 2, "handles": ["L0.p2"], "at": [50.0, 0.0]})
    wait(worker)
    went_on = threading.Event()
    drag = worker.shared._drag
    assert drag is not None
    go_on = drag.go_on

    def finished() -> object:
        values = go_on()
        went_on.set()
        return values

    move = drag.to

    def unfinished(x: float, y: float) -> object:
        values = move(x, y)
        drag.unfinished = True
        return values

    monkeypatch.setattr(drag, "go_on", finished)
    monkeypatch.setattr(drag, "to", unfinished)
    worker.receive(page.window, DragTo(1, 51.0, 0.0))
    assert went_on.wait(30)
    worker.receive(page.window, {"type": "drop", "id": 3})
    wait(worker)
    assert page.numbers("L0")[2] == pytest.approx(51)


def test_a_script_is_broken_off_between_lines(worker: Worker) -> None:
    page = opened(worker)
    text = "\n".join(f"add_point {k},0" for k in range(200))

    def broken(by: object, what: object) -> None:
        if len(worker.shared.session.document.entities) == 7:
            worker.receive(page.window, {"type": "break"})

    worker.shared.session.document.watchers.append(broken)
    worker.receive(page.window, {"type": "run", "id": 1, "text": text, "step": "points"})
    wait(worker)
    assert page.last("reply")["error"]["code"] == "E1405"
    assert not page.tables["entities"] and page.is_in_step()
    worker.receive(page.window, {"type": "run", "id": 2, "text": "add_point 1,1"})
    wait(worker)
    assert page.last("reply")["ok"]


def test_a_mistake_in_a_job_does_not_end_the_thread(
    worker: Worker, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> None:
        raise ZeroDivisionError("oops")

    with pytest.raises(ZeroDivisionError):
        worker.call(broken).result(30)
    page = opened(worker)
    worker.shared.receive = lambda *_: broken()  # type: ignore[method-assign]
    worker.receive(page.window, {"type": "run"})
    wait(worker)
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_verdicts_wait_for_a_pause(worker: Worker) -> None:
    page = opened(worker)
    wait(worker)
    event = held(worker)
    for k in range(30):
        worker.receive(page.window, {"type": "run", "id": k, "text": f"add_point {k},0"})
    event.set()
    wait(worker)
    worker.stop()
    kinds = [message["type"] for message in page.messages]
    last_reply = len(kinds) - 1 - kinds[::-1].index("reply")
    assert "verdict" not in kinds[kinds.index("reply") : last_reply]


def test_stopping_does_what_waits(shared: SharedSketch) -> None:
    worker = Worker(shared)
    worker.start()
    page = opened(worker)
    for k in range(20):
        worker.receive(page.window, {"type": "run", "id": k, "text": f"add_point {k},0"})
    worker.stop()
    assert len(page.tables["entities"]) == 20
