"""`arael sketch --serve` with the time of every stage of a frame, for the benchmark of frames.

``python benchmarks/sketch/timed_server.py FILE LOG``: when the server ends, `LOG` has one record
per place of the pointer, by its sequence: `STAGES` in milliseconds of the monotonic clock, and
`cpu`, processor time of the thread that solves.
"""

from __future__ import annotations

import struct
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import msgspec
from starlette.websockets import WebSocket

from arael.sketch.server import app
from arael.sketch.server.dragging import OpenDrag
from arael.sketch.server.protocol import FRAME, DragTo
from arael.sketch.server.serving import serve
from arael.sketch.server.shared import SharedSketch

STAGES = ("received", "begun", "solving", "solved", "encoded", "sent")
"""Read from the socket; taken up by the worker; solver's begin and end; given to the socket's
queue; taken from it."""

_HEAD = struct.Struct("<IIII")


class Times:
    """Times of frames, by sequence; hooks that take them."""

    def __init__(self) -> None:
        self.frames: dict[int, dict[str, float]] = {}
        self._current: dict[str, float] = {}

    def _of(self, sequence: int) -> dict[str, float]:
        return self.frames.setdefault(sequence, {})

    def received(self, read: Callable[[bytes], Any]) -> Callable[[bytes], Any]:
        """Around `protocol.received`."""

        def reading(data: bytes) -> Any:
            now = _now()
            found = read(data)
            if isinstance(found, DragTo):
                self._of(found.sequence)["received"] = now
            return found

        return reading

    def begun(self, drag_to: Callable[..., None]) -> Callable[..., None]:
        """Around `SharedSketch._drag_to`."""

        def dragging(shared: SharedSketch, window: Any, place: DragTo) -> None:
            self._current = one = self._of(place.sequence)
            one["begun"] = _now()
            cpu = time.thread_time()
            drag_to(shared, window, place)
            one["cpu"] = 1e3 * (time.thread_time() - cpu)
            one["encoded"] = _now()

        return dragging

    def solved(self, to: Callable[..., Any]) -> Callable[..., Any]:
        """Around `OpenDrag.to`."""

        def solving(*args: Any) -> Any:
            one = self._current
            one["solving"] = _now()
            found = to(*args)
            one["solved"] = _now()
            return found

        return solving

    def sent(self, send: Callable[..., Awaitable[None]]) -> Callable[..., Awaitable[None]]:
        """Around `WebSocket.send_bytes`."""

        async def sending(socket: WebSocket, data: bytes) -> None:
            self._sends(data)
            await send(socket, data)

        return sending

    def _sends(self, data: bytes) -> None:
        kind, sequence, _, _ = _HEAD.unpack_from(data)
        if kind == FRAME and sequence in self.frames:
            self.frames[sequence].setdefault("sent", _now())


def _now() -> float:
    return 1e3 * time.monotonic()


def main(file: str, log: str) -> None:
    """Serve a file until it is interrupted; then write the log."""
    times = Times()
    app.received = times.received(app.received)  # type: ignore[assignment]
    SharedSketch._drag_to = times.begun(SharedSketch._drag_to)  # type: ignore[method-assign]
    OpenDrag.to = times.solved(OpenDrag.to)  # type: ignore[method-assign]
    WebSocket.send_bytes = times.sent(WebSocket.send_bytes)  # type: ignore[assignment]
    try:
        serve(file, open_browser=False)
    finally:
        Path(log).write_bytes(msgspec.json.encode(times.frames))


if __name__ == "__main__":
    main(*sys.argv[1:])
