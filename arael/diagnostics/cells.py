"""Text for terminals: widths, tabs, and replacement of control characters.

Sources may be untrusted: control characters, escape sequences and direction marks are shown as
``U+FFFD``.
"""

from __future__ import annotations

import unicodedata

TAB = 4
_MARKS = frozenset("\u200b\u200c\u200d\u200e\u200f\ufeff\u202a\u202b\u202c\u202d\u202e"
                   "\u2066\u2067\u2068\u2069")  # fmt: skip


def char_width(char: str) -> int:
    """Columns that `char` takes: 0 for combining marks, 2 for wide characters, else 1."""
    if char.isascii():
        return TAB if char == "\t" else 1
    if unicodedata.combining(char):
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1


def width(text: str) -> int:
    """Columns that `text` takes."""
    return len(text) if text.isascii() and "\t" not in text else sum(map(char_width, text))


def printable(text: str) -> str:
    """`text` with tabs as blanks and control characters replaced."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(_shown(c) for c in text)


def _shown(char: str) -> str:
    if char == "\t":
        return " " * TAB
    if char in _MARKS or unicodedata.category(char) in ("Cc", "Cs"):
        return "\ufffd"
    return char


_MAX_MESSAGE = 4000


def safe_message(text: str) -> str:
    """Return a message made `printable`, with its line ends."""
    text = text if len(text) <= _MAX_MESSAGE else text[: _MAX_MESSAGE - 3] + "..."
    return "\n".join(printable(line) for line in text.split("\n"))
