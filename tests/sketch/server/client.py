"""A page without a browser: a WebSocket client that keeps a mirror of the document."""

from __future__ import annotations

import itertools
import json
import struct
from collections.abc import Callable
from types import TracebackType
from typing import Any

HEAD = struct.Struct("<IIII")


def encoded(content: Any) -> bytes:
    """A message of JSON as a page sends it."""
    payload = json.dumps(content).encode()
    return HEAD.pack(1, 0, len(payload), 0) + payload


def place(sequence: int, x: float, y: float) -> bytes:
    """A place of the pointer as a page sends it."""
    return HEAD.pack(3, sequence, 2, 0) + struct.pack("<dd", x, y)


class Mirror:
    """What a page knows of the document, by the messages it was sent."""

    def __init__(self) -> None:
        self.tables: dict[str, dict[str, Any]] = {}
        self.values: list[float] = []
        self.revision = -1
        self.hello: dict[str, Any] = {}
        self.verdict: dict[str, Any] = {}
        self.history: dict[str, Any] = {}
        self.messages: list[dict[str, Any]] = []
        self.frames: list[int] = []

    def take(self, data: bytes) -> dict[str, Any]:
        """Follow a message; the message, frames as ``type: frame``."""
        kind, sequence, count, _ = HEAD.unpack_from(data)
        if kind == 2:
            padded = count + count % 2
            offsets = struct.unpack_from(f"<{count}I", data, 16)
            numbers = struct.unpack_from(f"<{count}d", data, 16 + 4 * padded)
            assert len(data) == 16 + 4 * padded + 8 * count
            self._set(offsets, numbers)
            self.frames.append(sequence)
            return {"type": "frame", "sequence": sequence, "count": count}
        assert kind == 1 and count == len(data) - 16
        message: dict[str, Any] = json.loads(data[16:])
        getattr(self, f"_{message['type']}", self._other)(message)
        self.messages.append(message)
        return message

    def _set(self, offsets: Any, numbers: Any) -> None:
        if offsets:
            self.values += [0.0] * (max(offsets) + 1 - len(self.values))
        for offset, number in zip(offsets, numbers, strict=True):
            self.values[offset] = number

    def _other(self, message: dict[str, Any]) -> None: ...

    def _hello(self, message: dict[str, Any]) -> None:
        self.hello = message

    def _verdict(self, message: dict[str, Any]) -> None:
        self.verdict = message

    def _history(self, message: dict[str, Any]) -> None:
        self.history = message

    def _snapshot(self, message: dict[str, Any]) -> None:
        self.tables = {
            table: {one["name"]: one for one in records}
            for table, records in message["document"].items()
        }
        self.values = list(message["values"])
        self.revision = message["revision"]

    def _change(self, message: dict[str, Any]) -> None:
        assert message["from"] == self.revision
        for table, names in message["removed"].items():
            for name in names:
                del self.tables[table][name]
        for table, records in message["put"].items():
            self.tables[table] |= {one["name"]: one for one in records}
        for table, names in message.get("order", {}).items():
            self.tables[table] = {name: self.tables[table][name] for name in names}
        self._set(message["offsets"], message["numbers"])
        del self.values[message["size"] :]
        self.revision = message["revision"]

    def is_last_presence(self, windows: int) -> bool:
        """Whether the page was last sent that so many windows are open."""
        found = [one for one in self.messages if one["type"] == "presence"]
        return bool(found) and found[-1]["windows"] == windows

    def numbers(self, name: str) -> list[float]:
        """Numbers of an entity."""
        one = self.tables["entities"][name]
        return self.values[one["at"] : one["at"] + one["size"]]

    def shown(self) -> dict[str, Any]:
        """The document without the places of its numbers."""
        found: dict[str, Any] = {
            table: {name: dict(one) for name, one in records.items()}
            for table, records in self.tables.items()
        }
        for name, one in found["entities"].items():
            one["values"] = self.numbers(name)
            del one["at"]
        return found


class Page(Mirror):
    """A mirror over a WebSocket.

    Parameters
    ----------
    address : of the socket, with its token
    """

    def __init__(self, address: str, window: str = "w1", since: int = -1, **options: Any) -> None:
        super().__init__()
        from websockets.sync.client import connect

        suffix = f"&since={since}" if since >= 0 else ""
        self._context = connect(
            f"{address}&window={window}{suffix}", compression=None, max_size=None, **options
        )
        self.socket = self._context.__enter__()
        self._ids = itertools.count(1)

    def next(self, timeout: float = 30.0) -> dict[str, Any]:
        """The next message."""
        data = self.socket.recv(timeout)
        assert isinstance(data, bytes)
        return self.take(data)

    def until(
        self, wanted: str | Callable[[dict[str, Any]], bool], timeout: float = 30.0
    ) -> dict[str, Any]:
        """Follow messages to the first of a type, or the first that a function accepts."""
        while True:
            message = self.next(timeout)
            if message["type"] == wanted if isinstance(wanted, str) else wanted(message):
                return message

    def start(self) -> Page:
        """Follow messages to the snapshot."""
        self.until("snapshot")
        return self

    def send(self, content: dict[str, Any]) -> None:
        """Send JSON."""
        self.socket.send(encoded(content))

    def ask(self, kind: str, **content: Any) -> dict[str, Any]:
        """Send a message and follow to its reply."""
        number = next(self._ids)
        self.send({"type": kind, "id": number, **content})
        return self.until(lambda m: m["type"] == "reply" and m["id"] == number)

    def run(self, text: str, **options: Any) -> dict[str, Any]:
        """Run commands; the reply."""
        return self.ask("run", text=text, **options)

    def drag_to(self, sequence: int, x: float, y: float) -> dict[str, Any]:
        """Send a place of the pointer and follow to its frame."""
        self.socket.send(place(sequence, x, y))
        return self.until(lambda m: m["type"] == "frame" and m["sequence"] == sequence)

    def close(self) -> None:
        """Disconnect."""
        self.socket.close()

    def __enter__(self) -> Page:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
