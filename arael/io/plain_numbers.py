"""Numbers in the text of files and options.

Python's own readers accept more: ``1_5`` for 15, digits of other scripts.
"""

from __future__ import annotations


def is_plain(text: str) -> bool:
    """Whether `text` has no characters that only Python accepts in numbers."""
    return "_" not in text and text.isascii()


def real(text: str) -> float:
    """Parse `text` as a number; ValueError if it is not one. NaN and infinities pass."""
    if "_" in text or not text.isascii():  # `is_plain` inlined, to avoid a call for each cell
        raise ValueError(text)
    return float(text)


def whole(text: str) -> int:
    """Parse `text` as a whole number; ValueError if it is not one."""
    if "_" in text or not text.isascii():  # `is_plain` inlined, to avoid a call for each cell
        raise ValueError(text)
    return int(text)
