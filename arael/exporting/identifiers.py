"""C identifiers from names of a model."""

from __future__ import annotations

import re

_KEYWORDS = frozenset(
    word
    for line in (
        "auto break case char const continue default do double else enum extern float for goto if",
        "inline int long register restrict return short signed sizeof static struct switch typedef",
        "union unsigned void volatile while main abs sin cos tan exp log pow sqrt fabs floor ceil",
        "round y0 y1 yn j0 j1 jn gamma",
    )
    for word in line.split()
)
"""Keywords of C99, and functions of the C library that compilers know without a declaration."""


def identifier(name: str) -> str:
    """Write `name` as a C identifier: ``PointLandmark`` as ``point_landmark``.

    Dots become underscores, letters beyond ASCII their code, and keywords have a `_` behind.
    """
    split = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    plain = "".join(
        c if c.isascii() and c.isalnum() else f"u{ord(c):x}" if c.isalnum() else "_"
        for c in split.lower()
    )
    plain = re.sub("_+", "_", plain).strip("_")
    if not plain or plain[0].isdigit():
        plain = f"n{plain}"
    return f"{plain}_" if plain in _KEYWORDS else plain


_FILES = frozenset(
    {"math", "stdio", "stdlib", "string", "c", "m"}
    | {"all", "clean", "install", "test", "help", "package", "edit_cache"}
)
"""Headers and libraries of C, and targets of CMake: no project may have their names."""


def project_name(name: str) -> str:
    """Name of the files of a model: its own, but for what would hide a header or a target."""
    plain = identifier(name)
    return f"{plain}_model" if plain in _FILES else plain


class Names:
    """Identifiers of one scope, each taken once: a second ``pose`` is ``pose_2``."""

    def __init__(self, taken: tuple[str, ...] = ()) -> None:
        self._taken = set(taken)

    def take(self, name: str) -> str:
        """Return `name`, or a numbered form of it that is still free."""
        number, free = 1, name
        while free in self._taken:
            number += 1
            free = f"{name}_{number}"
        self._taken.add(free)
        return free
