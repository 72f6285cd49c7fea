"""Messages between the server and a page: a binary head of 16 bytes, then the payload.

Little endian: u32 kind, u32 sequence, u32 count, u32 revision.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic

JSON, FRAME, DRAG = 1, 2, 3
"""Kinds: JSON; numbers of a drag (to the page); a place of the pointer (to the server)."""

MAX_MESSAGE = 64 * 1024 * 1024
"""Bytes of a message to the server; files for `import` are part of one."""

_HEAD = struct.Struct("<IIII")
_PLACE = struct.Struct("<dd")
_DRAG_HEAD = DRAG.to_bytes(4, "little")
_OFFSET, _NUMBER = np.dtype("<u4"), np.dtype("<f8")


def _plain(value: Any) -> Any:
    """A number or array of NumPy, or another mapping, as JSON has it."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise NotImplementedError(type(value).__name__)


_ENCODER = msgspec.json.Encoder(enc_hook=_plain)
_DECODER = msgspec.json.Decoder(dict[str, Any])


class DragTo(msgspec.Struct, frozen=True):
    """Where the pointer is, in the sketch.

    Attributes
    ----------
    sequence : counts up within a drag
    x, y : the place
    """

    sequence: int
    x: float
    y: float


def json_message(content: Any, revision: int = 0) -> bytes:
    """A message of JSON."""
    payload = _ENCODER.encode(content)
    return _HEAD.pack(JSON, 0, len(payload), revision & 0xFFFFFFFF) + payload


def frame_message(
    sequence: int, offsets: NDArray[np.int64], numbers: NDArray[np.float64], revision: int
) -> bytes:
    """A frame of a drag: ``values[offsets] = numbers``; offsets are padded to 8 bytes."""
    count = len(offsets)
    padding = b"\0\0\0\0" if count % 2 else b""
    return b"".join(
        (
            _HEAD.pack(FRAME, sequence & 0xFFFFFFFF, count, revision & 0xFFFFFFFF),
            offsets.astype(_OFFSET).tobytes(),
            padding,
            numbers.astype(_NUMBER, copy=False).tobytes(),
        )
    )


def received(data: bytes | memoryview) -> DragTo | dict[str, Any]:
    """A message of a page.

    Raises
    ------
    AraelError
        E1401: it is none.
    """
    if len(data) > MAX_MESSAGE:
        raise _malformed(f"{len(data):,} bytes; at most {MAX_MESSAGE:,} are read")
    if len(data) < _HEAD.size:
        raise _malformed(f"expected a head of {_HEAD.size} bytes, found {len(data)}")
    kind, sequence, count, _ = _HEAD.unpack_from(data)
    payload = memoryview(data)[_HEAD.size :]
    if kind == DRAG:
        if len(payload) != _PLACE.size or count != 2:
            raise _malformed("a place is two numbers of 64 bits")
        x, y = _PLACE.unpack(payload)
        if not (abs(x) < np.inf and abs(y) < np.inf):
            raise _malformed("a place is finite")
        return DragTo(sequence, x, y)
    if kind != JSON:
        raise _malformed(f"no kind {kind}")
    if count != len(payload):
        raise _malformed(f"{count} bytes were announced, {len(payload)} came")
    try:
        found = _DECODER.decode(payload)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise _malformed(str(error) or type(error).__name__) from None
    if not isinstance(found.get("type"), str):
        raise _malformed("expected a `type`")
    return found


def _malformed(reason: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1401",
            f"a message that cannot be read: {reason}",
            help=("reload the page: it may be of another version than the server",),
        )
    )
