"""New values of dimensions, given again and again: only the number of the line is read anew."""

from __future__ import annotations

import math
import re

from arael.sketch.document.document import Document
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount, Dimension

_LINE = re.compile(
    r"([a-z_]+(?: [A-Za-z]+\d+(?:\.\w+)?)+) (-?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\Z", re.ASCII
)
_MOST = 1024


class Repeats:
    """Dimensions by the part of a command line before their value: ``length L0``.

    A line that only differs in its number from one that was run before means the same dimension, as
    long as the document holds the very record that the last such line left: handles are no names
    of variables, and no other dimension of the same quantity can have been added.
    """

    def __init__(self) -> None:
        self._known: dict[str, Dimension] = {}

    def note(self, line: str, made: Dimension) -> None:
        """Keep which dimension a line has given a value."""
        found = _LINE.match(line)
        # The outline of an area may be another one when it is given again.
        if found is None or made.kind == "area" or DIMENSIONS.get(made.kind) is None:
            return
        if len(self._known) >= _MOST:
            self._known.clear()
        self._known[found[1]] = made

    def find(self, line: str, document: Document) -> tuple[Dimension, Amount] | None:
        """The dimension that a line gives a value, and the value; None: it has to be read."""
        found = _LINE.match(line)
        known = self._known.get(found[1]) if found is not None else None
        if found is None or known is None or document.dimensions.get(known.name) is not known:
            return None
        number = float(found[2])
        return (known, Amount(found[2], number)) if math.isfinite(number) else None
