"""What is refused before anything is solved: duplicates, geometry without extent, wrong values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Dimension
from arael.sketch.editing.operands import same_relation
from arael.sketch.solve.extents import COLLAPSED, extents_of, lost

Floats = NDArray[np.float64]

#: Lines and radii shorter than this part of the sketch's size have no direction.
SMALLEST = 1e-9
#: Coordinates and values above this have squares that are no numbers.
LARGEST = 1e100


def check_extent(kind: str, numbers: list[float], size: float) -> None:
    """Refuse a line without length, a circle without radius, an arc without sweep.

    Raises
    ------
    AraelError
        E1220
    """
    check_largest(numbers)
    least = SMALLEST * size
    for what, found in extents_of(kind, numbers):
        if not found > least:
            raise AraelError(
                Diagnostic(
                    "E1220",
                    f"a {kind} needs a {what} above zero, found {found:g}",
                    help=("give it points that are apart",),
                )
            )


def check_largest(numbers: Iterable[float]) -> None:
    """Refuse numbers that cannot be calculated with; AraelError E1220."""
    for number in numbers:
        if not abs(number) <= LARGEST:
            message = f"coordinates and sizes are at most {LARGEST:g}, found {number:g}"
            raise AraelError(Diagnostic("E1220", message))


def check_remains(
    document: Document, names: Sequence[str], old: Floats, size: float, cause: str = ""
) -> None:
    """Refuse what makes a line, circle or ellipse collapse.

    Parameters
    ----------
    names : entities whose numbers changed
    old : all numbers of the document before
    size : of the drawing
    cause : what was asked for, in words

    Raises
    ------
    AraelError
        E1220
    """
    least = COLLAPSED * size
    for name in names:
        entity = document.entities[name]
        what = lost(entity, old, document.values, least)
        if what:
            raise AraelError(
                Diagnostic(
                    "E1220",
                    f"{f'`{cause}`' if cause else 'this'} would leave nothing of `{name}`: "
                    f"its {what} would be 0",
                    notes=("the sketch is left as it was",),
                    help=(f"`info {name}` lists what holds it",),
                )
            )


def check_new_constraint(
    document: Document, kind: str, args: tuple[str, ...], among: Iterable[str]
) -> None:
    """Refuse a relation that is there already; AraelError E1221 with its name.

    Parameters
    ----------
    among : names of the records that involve the first argument's entity
    """
    for name in among:
        other = document.constraints.get(name)
        if other is not None and other.kind == kind and same_relation(kind, args, other.args):
            raise _duplicate(kind, args, other)


def check_itself(document: Document, kind: str, args: tuple[str, ...]) -> None:
    """Refuse what relates a curve to its own points.

    Raises
    ------
    AraelError
        E1222: both ends of a line tangent; a point on, or in the middle of, its own line, arc,
        circle or ellipse
    """
    if len(args) != 2 or args[0].partition(".")[0] != args[1].partition(".")[0]:
        return
    name = args[1].partition(".")[0]
    entity = document.entities[name].kind
    of_points = kind in ("point_on", "midpoint", "distance") and entity not in ("bezier", "bspline")
    if of_points and args[1] == name:
        message = f"`{kind}` takes a point of something else than `{name}`, found `{args[0]}`"
        raise AraelError(Diagnostic("E1222", message, help=("name a point of another entity",)))
    if kind in ("tangent", "smooth") and entity == "line":
        message = f"`{kind}` takes ends of two curves, found both of `{name}`"
        raise AraelError(Diagnostic("E1222", message, help=("name an end of another curve",)))


def _duplicate(kind: str, args: tuple[str, ...], other: Constraint) -> AraelError:
    state = "" if other.active else ", switched off"
    return AraelError(
        Diagnostic(
            "E1221",
            f"`{kind} {' '.join(args)}` is there already: `{other.name}`{state}",
            help=("`delete " + other.name + "` takes it out",),
        )
    )


def same_dimension(
    document: Document, kind: str, args: tuple[str, ...], among: Iterable[str]
) -> Dimension | None:
    """A dimension of the same quantity, which a new value replaces.

    Parameters
    ----------
    among : names of the records that involve the first argument's entity
    """
    dimensions = document.dimensions
    found = [
        one
        for one in map(dimensions.get, among)
        if one is not None and one.kind == kind and same_relation(kind, args, one.args)
    ]
    if len(found) > 1:  # of a file: the first in the document's order
        order = list(dimensions)
        found.sort(key=lambda one: order.index(one.name))
    return found[0] if found else None


#: Quantities that must be above zero, for lines and circles to have an extent.
_POSITIVE = frozenset(
    {"length", "radius", "diameter", "radius_b", "sweep", "arc_length", "total_length", "area"}
)


def check_amounts(kind: str, amounts: tuple[Amount | None, Amount | None, Amount | None]) -> None:
    """Refuse values that the quantity cannot have; AraelError E1220.

    Parameters
    ----------
    amounts : value, low, high
    """
    value, low, high = amounts
    check_largest(one.number for one in amounts if one is not None)
    if value is not None:
        _check_value(kind, value)
    if high is not None and kind in _POSITIVE and not high.number > 0.0:
        _check_value(kind, high)
    if low is not None and high is not None and low.number > high.number:
        raise AraelError(
            Diagnostic(
                "E1220",
                f"the range of `{kind}` is empty: {low.number:g} to {high.number:g}",
                help=("the lower bound comes first",),
            )
        )


def _check_value(kind: str, amount: Amount) -> None:
    number = amount.number
    if kind in _POSITIVE and not number > 0.0:
        reason = "must be above 0"
    elif kind == "sweep" and number > 360.0:
        reason = "is at most 360 degrees"
    elif kind == "angle" and abs(number) > 180.0:
        reason = "is at most 180 degrees"
    else:
        return
    shown = amount.text if amount.text == f"{number:g}" else f"{amount.text} = {number:g}"
    raise AraelError(Diagnostic("E1220", f"`{kind}` {reason}, found {shown}"))


def check_collapse(document: Document, kind: str, args: tuple[str, ...]) -> None:
    """Refuse to make two points of one line or arc one; AraelError E1220."""
    if kind != "coincident":
        return
    names = {arg.partition(".")[0] for arg in args}
    entity = document.entities[next(iter(names))]
    if len(names) == 1 and entity.kind in ("line", "arc", "earc"):
        raise AraelError(
            Diagnostic(
                "E1220",
                f"`{args[0]}` and `{args[1]}` at one place would leave nothing of `{entity.name}`",
                help=("delete it if it is not needed",),
            )
        )
