"""Messages: the binary head, and what is refused of those that come."""

from __future__ import annotations

import json
import struct
from types import MappingProxyType

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.server.protocol import DragTo, frame_message, json_message, received
from tests.sketch.server.client import HEAD, encoded, place


def test_json_comes_as_it_was_sent() -> None:
    assert received(encoded({"type": "run", "id": 3, "text": "ä"})) == {
        "type": "run",
        "id": 3,
        "text": "ä",
    }


def test_a_place_comes_as_it_was_sent() -> None:
    assert received(place(7, 1.5, -0.0)) == DragTo(7, 1.5, -0.0)


def test_the_head_of_json_has_its_size_and_the_revision() -> None:
    data = json_message({"type": "idle"}, 2**32 + 5)
    assert HEAD.unpack_from(data) == (1, 0, len(data) - 16, 5)
    assert json.loads(data[16:]) == {"type": "idle"}


def test_numbers_of_numpy_are_json() -> None:
    content = {"a": np.float64(1.5), "b": np.int64(2), "c": np.bool_(True), "d": np.arange(2)}
    found = json.loads(json_message({**content, "e": MappingProxyType({"x": 1})})[16:])
    assert found == {"a": 1.5, "b": 2, "c": True, "d": [0, 1], "e": {"x": 1}}


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_numbers_of_a_frame_begin_at_8_bytes(count: int) -> None:
    offsets, numbers = np.arange(count), np.arange(count) + 0.5
    data = frame_message(9, offsets, numbers, 4)
    assert HEAD.unpack_from(data) == (2, 9, count, 4)
    start = 16 + 8 * ((count + 1) // 2)
    assert struct.unpack_from(f"<{count}d", data, start) == tuple(numbers)
    assert len(data) == start + 8 * count


MALFORMED = {
    "nothing": b"",
    "a short head": b"\1\0\0",
    "a kind that does not exist": HEAD.pack(9, 0, 0, 0),
    "numbers of a drag from a page": HEAD.pack(2, 0, 0, 0),
    "JSON of another size": HEAD.pack(1, 0, 5, 0) + b"{}",
    "no JSON": HEAD.pack(1, 0, 3, 0) + b"{]}",
    "no object": HEAD.pack(1, 0, 2, 0) + b"[]",
    "no type": HEAD.pack(1, 0, 2, 0) + b"{}",
    "a type that is no text": encoded({"type": 3}),
    "no UTF-8": HEAD.pack(1, 0, 4, 0) + b'{"\xff"',
    "deep JSON": HEAD.pack(1, 0, 200_000, 0) + b"[" * 200_000,
    "a place that is not finite": place(1, float("nan"), 0.0),
    "an infinite place": place(1, 0.0, float("inf")),
    "half a place": HEAD.pack(3, 0, 2, 0) + b"\0" * 8,
}


@pytest.mark.parametrize("name", MALFORMED)
def test_what_cannot_be_read_is_refused(name: str) -> None:
    with pytest.raises(AraelError) as caught:
        received(MALFORMED[name])
    assert caught.value.diagnostics[0].code == "E1401"


def test_a_message_that_is_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.sketch.server.protocol.MAX_MESSAGE", 100)
    with pytest.raises(AraelError, match="at most 100 are read"):
        received(encoded({"type": "run", "text": "x" * 100}))
