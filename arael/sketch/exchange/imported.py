"""What a foreign file brought: geometry, and constraints to choose from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from arael.sketch.document.document import Document
from arael.sketch.document.records import Constraint
from arael.sketch.layout.sides import side_of


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A constraint that the imported geometry satisfies within the tolerance.

    Attributes
    ----------
    kind, args : of the constraint
    gap : by how much it is missed now, as a length
    """

    kind: str
    args: tuple[str, ...]
    gap: float

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
            return [document.put("constraints", _constraint(document, one)) for one in chosen]


def _constraint(document: Document, one: Suggestion) -> Constraint:
    """The constraint, on the side on which the geometry lies."""
    side = side_of(document, one.kind, one.args)
    return Constraint(_name(document, one), one.kind, one.args, side=side)


def _name(document: Document, one: Suggestion) -> str:
    """``CL0H`` and ``CL0V`` for the direction of a line, otherwise the next number."""
    if one.kind in ("horizontal", "vertical") and len(one.args) == 1:
        return f"C{one.args[0]}{one.kind[0].upper()}"
    return document.next_name("C")
