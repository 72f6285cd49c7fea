"""Places of the pointer that are answered as they are read, and the usual way of the others."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests import optional

optional.require("starlette")
optional.require("websockets")

from arael.sketch.server.app import SocketLink  # noqa: E402
from arael.sketch.server.quick_socket import QuickSocket  # noqa: E402
from tests.event_loop import completed  # noqa: E402
from tests.sketch.server.client import Page, encoded, place  # noqa: E402
from tests.sketch.server.inside import InsideServer  # noqa: E402


class Noted:
    """Messages that were taken at once, and frames that were sent at once."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.taken: list[bytes] = []
        self.sent = 0
        self.socket: QuickSocket | None = None
        take, send = QuickSocket.handle_bytes, QuickSocket.send_now

        def handle_bytes(socket: QuickSocket, event: object) -> None:
            takes = socket.takes

            def taking(data: bytes) -> bool:
                assert takes is not None
                found = takes(data)
                if found:
                    self.taken.append(bytes(data))
                return found

            socket.takes = taking if takes is not None else None
            take(socket, event)
            socket.takes = takes

        def send_now(socket: QuickSocket, data: bytes) -> bool:
            found = send(socket, data)
            self.sent += found
            self.socket = socket
            return found

        monkeypatch.setattr(QuickSocket, "handle_bytes", handle_bytes)
        monkeypatch.setattr(QuickSocket, "send_now", send_now)


@pytest.fixture
def noted(monkeypatch: pytest.MonkeyPatch) -> Noted:
    return Noted(monkeypatch)


@pytest.fixture
def page(tmp_path: Path, noted: Noted) -> Iterator[Page]:
    """A page with a line whose end is being dragged."""
    with InsideServer(tmp_path / "a.json") as server, Page(server.socket).start() as found:
        found.run("add_line 0,0 50,0")
        found.ask("drag", handles=["L0.p2"], at=[50.0, 0.0])
        noted.sent = 0
        yield found


def test_a_place_is_answered_as_it_is_read(
    page: Page, noted: Noted, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("arael.sketch.server.worker.SHORT", 60.0)
    for k in range(1, 6):
        page.drag_to(k, 50.0 + k, 1.0)
    assert page.numbers("L0")[2:] == pytest.approx([55.0, 1.0])
    # the first may come while the thread of the sketch is still busy with what it did before
    assert len(noted.taken) == 5 and noted.sent >= 4
    # another message takes the usual way, and so does a place that is none
    page.run("add_point 1,2")
    page.socket.send(place(6, float("nan"), 1.0))
    said = page.until("message")
    assert said["level"] == "error" and "a place is finite" in said["text"]
    assert len(noted.taken) == 5


def test_a_place_behind_other_messages_waits_for_them(page: Page, noted: Noted) -> None:
    raw = page.socket.protocol
    # in one piece: a message of the usual way, and two places behind it
    drop = encoded({"type": "drop", "id": 90})
    drag = encoded({"type": "drag", "id": 91, "handles": ["L0.p1"], "at": [0.0, 0.0]})
    for one in (drop, drag, place(1, -5.0, 0.0), place(2, -9.0, 3.0)):
        raw.send_binary(one)
    page.socket.socket.sendall(b"".join(raw.data_to_send()))
    page.until(lambda one: one["type"] == "frame" and one["sequence"] == 2)
    assert page.numbers("L0") == pytest.approx([-9.0, 3.0, 50.0, 0.0])
    assert noted.taken == []
    # of several places in one piece the newest is used, and only the first is taken at once
    for k in range(3, 40):
        raw.send_binary(place(k, -9.0 - k, 3.0))
    page.socket.socket.sendall(b"".join(raw.data_to_send()))
    page.until(lambda one: one["type"] == "frame" and one["sequence"] == 39)
    assert page.numbers("L0") == pytest.approx([-48.0, 3.0, 50.0, 0.0])
    assert len(noted.taken) == 1 and len(page.frames) < 20


def test_a_link_sends_at_once_only_what_nothing_precedes() -> None:
    import asyncio

    class Socket:
        """Sends slowly."""

        def __init__(self) -> None:
            self.sent: list[bytes] = []
            self.began = 0
            self.go = asyncio.Event()

        async def send_bytes(self, data: bytes) -> None:
            self.began += 1
            await self.go.wait()
            self.sent.append(data)

    async def run() -> list[bytes]:
        socket = Socket()
        can = True

        def at_once(data: bytes) -> bool:
            if can:
                socket.sent.append(data)
            return can

        link = SocketLink(asyncio.get_running_loop(), at_once)
        pump = asyncio.create_task(link.pump(socket))  # type: ignore[arg-type]
        link.send(b"1")
        other = threading.Thread(target=link.send, args=(b"2",))
        other.start()
        other.join()
        link.send(b"3")  # behind one that waits
        await until(lambda: socket.began == 1)
        link.send(b"4")  # one is on its way
        socket.go.set()
        await until(lambda: len(socket.sent) == 4 and not link._is_sending)
        link.send(b"5")
        can = False
        link.send(b"6")
        await until(lambda: len(socket.sent) == 6)
        pump.cancel()
        assert not link.is_behind and socket.began == 4
        return socket.sent

    async def until(holds: Callable[[], bool]) -> None:
        for _ in range(10_000):
            if holds():
                return
            await asyncio.sleep(0.001)
        raise AssertionError("not within ten seconds")

    assert completed(run()) == [b"1", b"2", b"3", b"4", b"5", b"6"]


def test_nothing_is_sent_at_once_after_the_page_has_gone(page: Page, noted: Noted) -> None:
    page.drag_to(1, 51.0, 0.0)
    page.drag_to(2, 52.0, 0.0)
    gone = noted.socket
    assert gone is not None
    page.close()
    for _ in range(1000):
        if gone.transport.is_closing() and gone.takes is None:
            break
        threading.Event().wait(0.01)
    assert gone.takes is None and not gone.send_now(b"x")
