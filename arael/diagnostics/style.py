"""Colour for messages: styles by meaning, and whether a stream supports them."""

from __future__ import annotations

import os
from typing import IO, Literal

Style = Literal["error", "warning", "note", "help", "frame", "secondary", "strong", "plain"]

_CODES: dict[Style, str] = {
    "error": "1;31",
    "warning": "1;33",
    "note": "1;32",
    "help": "1;36",
    "frame": "1;34",
    "secondary": "1;34",
    "strong": "1",
}


def paint(text: str, style: Style, color: bool) -> str:
    """`text` in ANSI colours where `color` is set."""
    code = _CODES.get(style)
    return f"\x1b[{code}m{text}\x1b[0m" if color and code and text else text


def use_color(stream: IO[str]) -> bool:
    """Return whether to write colours to `stream`.

    ``NO_COLOR`` (any value) turns them off, ``FORCE_COLOR`` on, otherwise terminals other than
    `dumb` get colours; see https://no-color.org.
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    isatty = getattr(stream, "isatty", None)
    return bool(isatty and isatty()) and os.environ.get("TERM") != "dumb"
