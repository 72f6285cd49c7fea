"""Numbers in text, as files and options have them.

Python's own readers take more than is meant: ``1_5`` for 15, digits of other scripts.
"""

from __future__ import annotations


def is_plain(text: str) -> bool:
    """Whether `text` has none of what only Python takes for a part of a number."""
    return "_" not in text and text.isascii()


def real(text: str) -> float:
    """Return the number that `text` is; ValueError if it is none. NaN and infinities pass."""
    if "_" in text or not text.isascii():  # as `is_plain`, without a call for each cell
        raise ValueError(text)
    return float(text)


def whole(text: str) -> int:
    """Return the whole number that `text` is; ValueError if it is none."""
    if "_" in text or not text.isascii():  # as `is_plain`, without a call for each cell
        raise ValueError(text)
    return int(text)
