"""The thread of the sketch: turns, merged places of the pointer, breaking off, mistakes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

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


def frames_by(worker: Worker, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The threads that make frames from now on."""
    found: list[int] = []
    frame = worker.shared.receive

    def receive(*args: object) -> None:
        if isinstance(args[1], DragTo):
            found.append(threading.get_ident())
        frame(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(worker.shared, "receive", receive)
    return found


def rest(worker: Worker) -> None:
    """Until the thread waits for messages."""
    wait(worker)
    while worker._taken:
        pass


class Later:
    """What a thread has put off until it has received all messages."""

    def __init__(self) -> None:
        self.jobs: list[Callable[[], None]] = []

    def __call__(self, job: Callable[[], None]) -> None:
        self.jobs.append(job)

    def run(self) -> None:
        """Run it in this thread."""
        while self.jobs:
            self.jobs.pop(0)()


def test_a_place_that_nothing_precedes_is_solved_by_the_thread_that_received_it(
    worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, later = opened(worker), Later()
    worker.receive(page.window, {"type": "run", "id": 1, "text": "add_line 0,0 50,0"})
    worker.receive(page.window, {"type": "drag", "id": 2, "handles": ["L0.p2"], "at": [50.0, 0.0]})
    threads = frames_by(worker, monkeypatch)
    monkeypatch.setattr("arael.sketch.server.worker.SHORT", 60.0)
    rest(worker)
    # of the places that have been received the newest is used
    worker.receive(page.window, DragTo(1, 51.0, 0.0), later)
    worker.receive(page.window, DragTo(2, 52.0, 0.0), later)
    assert page.frames == []
    later.run()
    assert page.frames == [2] and page.numbers("L0")[2] == pytest.approx(52)
    # while the other thread is busy, it makes the frame
    event = held(worker)
    worker.receive(page.window, DragTo(3, 53.0, 0.0), later)
    assert not later.jobs
    event.set()
    rest(worker)
    assert page.frames == [2, 3]
    # a message that comes after it is not answered before it
    worker.receive(page.window, DragTo(4, 54.0, 0.0), later)
    worker.receive(page.window, {"type": "ask", "id": 3, "what": "free"}, later)
    rest(worker)
    later.run()
    assert page.frames == [2, 3, 4]
    # frames that take long are left to the other thread, so that messages are read meanwhile
    monkeypatch.setattr("arael.sketch.server.worker.SHORT", 0.0)
    worker.receive(page.window, DragTo(5, 55.0, 0.0), later)
    assert not later.jobs
    rest(worker)
    assert page.frames == [2, 3, 4, 5] and page.numbers("L0")[2] == pytest.approx(55)
    mine = threading.get_ident()
    assert [one == mine for one in threads] == [True, False, False, False]
    worker.receive(page.window, {"type": "drop", "id": 4})
    wait(worker)
    assert page.history["done"][-1] == "drag L0.p2" and page.is_in_step()


def test_a_frame_that_was_cut_short_is_gone_on_with_by_the_worker(
    worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = opened(worker)
    worker.receive(page.window, {"type": "run", "id": 1, "text": "add_line 0,0 50,0"})
    worker.receive(page.window, {"type": "drag", "id": 2, "handles": ["L0.p2"], "at": [50.0, 0.0]})
    monkeypatch.setattr("arael.sketch.server.worker.SHORT", 60.0)
    rest(worker)
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
    later = Later()
    worker.receive(page.window, DragTo(1, 51.0, 0.0), later)
    assert later.jobs
    later.run()
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
