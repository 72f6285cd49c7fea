"""What a foreign file brought: geometry, and constraints to choose from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from arael.sketch.document.document import Document
from arael.sketch.document.records import Constraint


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A constraint that the imported geometry satisfies within the tolerance.

    Attributes
    ----------
    kind, args, side, mode : of the constraint
    gap : by how much it is missed now, as a length
    """

    kind: str
    args: tuple[str, ...]
    gap: float
    side: int = 0
    mode: str = ""

    def __str__(self) -> str:
        return f"{self.kind} {' '.join(self.args)}"


@dataclass(slots=True)
class Imported:
    """A document of the geometry of a foreign file.

    Attributes
    ----------
    document : geometry alone, without constraints
    suggestions : constraints that were recognised; none is applied until it is accepted
    notes : what was left out or changed, in words
    """

    document: Document
    suggestions: list[Suggestion] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def accept(self, suggestions: Iterable[Suggestion] | None = None) -> list[Constraint]:
        """Add suggested constraints (by default all of them) in one step of undo.

        The constraints are recorded as they are; the geometry moves when the sketch is solved.
        """
        chosen = list(self.suggestions if suggestions is None else suggestions)
        document = self.document
        with document.transaction("accept"):
            return [
                document.put(
                    "constraints",
                    Constraint(_name(document, one), one.kind, one.args, (), one.side, one.mode),
                )
                for one in chosen
            ]


def _name(document: Document, one: Suggestion) -> str:
    """``CL0H`` and ``CL0V`` for the direction of a line, otherwise the next number."""
    if one.kind in ("horizontal", "vertical") and len(one.args) == 1:
        return f"C{one.args[0]}{one.kind[0].upper()}"
    return document.next_name("C")
