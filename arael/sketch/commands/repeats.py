"""New values of dimensions, given again and again: only the number of the line is read anew."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from arael.sketch.document.document import Document
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount, Dimension

if TYPE_CHECKING:
    from arael.sketch.commands.replies import Reply
    from arael.sketch.commands.session import Session

Answer: TypeAlias = "Callable[[Session, Dimension, Dimension], Reply]"

_LINE = re.compile(
    r"([a-z_]+(?: [A-Za-z]+\d+(?:\.\w+)?)+) (-?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\Z", re.ASCII
)
_MOST = 1024


class Repeat(NamedTuple):
    """A line that gives a dimension a value.

    Attributes
    ----------
    line : its part before the value
    known : the dimension
    value : new
    answer : replies to such a line, by the dimension as it was and as it is
    """

    line: str
    known: Dimension
    value: Amount
    answer: Answer


class Repeats:
    """Dimensions by the part of a command line before their value: ``length L0``.

    A line that only differs in its number from one that was run before means the same dimension, as
    long as the document holds the very record that the last such line left: handles are no names
    of variables, and no other dimension of the same quantity can have been added.
    """

    def __init__(self) -> None:
        self._known: dict[str, tuple[Dimension, Answer]] = {}

    def note(self, line: str, made: Dimension, answer: Answer) -> None:
        """Keep which dimension a line has given a value, and what says that it has a new one."""
        found = _LINE.match(line)
        # The outline of an area may be another one when it is given again.
        if found is None or made.kind == "area" or DIMENSIONS.get(made.kind) is None:
            return
        if len(self._known) >= _MOST:
            self._known.clear()
        self._known[found[1]] = made, answer

    def keep(self, repeat: Repeat, made: Dimension) -> None:
        """Keep the dimension with the value that a line has given it."""
        self._known[repeat.line] = made, repeat.answer

    def find(self, line: str, document: Document) -> Repeat | None:
        """The dimension that a line gives a value, and the value; None: the line must be read."""
        found = _LINE.match(line)
        if found is None or found[1] not in self._known:
            return None
        known, answer = self._known[found[1]]
        number = float(found[2])
        if document.dimensions.get(known.name) is not known or not math.isfinite(number):
            return None
        return Repeat(found[1], known, Amount(found[2], number), answer)
