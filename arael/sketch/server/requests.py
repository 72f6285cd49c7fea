"""Messages of pages by their type, and what each does."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.expressions.vectors import Vec
from arael.sketch.server import asking, files

if TYPE_CHECKING:
    from arael.sketch.server.shared import SharedSketch
    from arael.sketch.server.windows import Window

Message = dict[str, Any]
Handler = Callable[["SharedSketch", "Window", Message], Message | None]

MAX_TEXT = 4 * 1024 * 1024
"""Characters of commands in one message."""


def text_of(message: Message, key: str, default: str | None = None) -> str:
    """A text of a message.

    Raises
    ------
    AraelError
        E1401: it is missing, no text, or too long
    """
    found = message.get(key, default)
    if not isinstance(found, str) or len(found) > MAX_TEXT:
        raise malformed(message, key, "a text")
    return found


def texts_of(message: Message, key: str) -> list[str]:
    """A list of texts of a message; empty if it is missing."""
    found = message.get(key) or []
    if not isinstance(found, list) or not all(isinstance(one, str) for one in found):
        raise malformed(message, key, "a list of texts")
    return found


def place_of(message: Message, key: str) -> tuple[float, float]:
    """A place in a message."""
    found = message.get(key)
    if (
        not isinstance(found, list)
        or len(found) != 2
        or not all(isinstance(x, int | float) and math.isfinite(x) for x in found)
    ):
        raise malformed(message, key, "two finite numbers")
    return float(found[0]), float(found[1])


def malformed(message: Message, key: str, expected: str) -> AraelError:
    """E1401: a part of a message is not what is expected."""
    kind = str(message.get("type"))[:40]
    return AraelError(Diagnostic("E1401", f"message `{kind}`: expected {expected} as `{key}`"))


def _run(shared: SharedSketch, window: Window, message: Message) -> Message:
    return shared.run(
        window,
        window.name,
        text_of(message, "text"),
        texts_of(message, "extras"),
        text_of(message, "step", "")[:200],
    )


def _explain(shared: SharedSketch, window: Window, message: Message) -> Message:
    return shared.run(window, window.name, f"explain {text_of(message, 'text')}")


def _ask(shared: SharedSketch, window: Window, message: Message) -> Message:
    return asking.asked(shared, window, text_of(message, "what"), message)


def _drag(shared: SharedSketch, window: Window, message: Message) -> Message:
    shared.begin_drag(window, texts_of(message, "handles"), place_of(message, "at"))
    return {"ok": True, "text": "", "names": [], "created": [], "notes": []}


def _drop(shared: SharedSketch, window: Window, message: Message) -> Message:
    shared.end_drag(window, bool(message.get("cancel")))
    return {"ok": True, "text": "", "names": [], "created": [], "notes": []}


def _view(shared: SharedSketch, window: Window, message: Message) -> None:
    if "selection" in message:
        names = texts_of(message, "selection")
        find = shared.session.document.find
        window.state.selection = {
            name: None for name in names if find(name.partition(".")[0]) is not None
        }
    if message.get("cursor") is not None:
        window.state.cursor = Vec(*place_of(message, "cursor"))


def _refresh(shared: SharedSketch, window: Window, message: Message) -> None:
    shared.send_snapshot(window)


def _file(shared: SharedSketch, window: Window, message: Message) -> Message:
    return files.done(shared, window, text_of(message, "do"), message)


def _answer(shared: SharedSketch, window: Window, message: Message) -> None:
    allow, always = message.get("allow") is True, message.get("always") is True
    shared.permissions.answer(message.get("id"), allow, always)


def _revoke(shared: SharedSketch, window: Window, message: Message) -> None:
    shared.permissions.revoke(message.get("session"))


def _nothing(shared: SharedSketch, window: Window, message: Message) -> None:
    """Nothing: `break` acts before it comes here."""


HANDLERS: Mapping[str, Handler] = MappingProxyType(
    {
        "run": _run,
        "explain": _explain,
        "ask": _ask,
        "drag": _drag,
        "drop": _drop,
        "view": _view,
        "refresh": _refresh,
        "file": _file,
        "answer": _answer,
        "revoke": _revoke,
        "break": _nothing,
        "latency": _nothing,
    }
)
