"""What is refused before anything is solved: duplicates, geometry without extent, wrong values."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Dimension
from arael.sketch.editing.measures import size_of
from arael.sketch.editing.operands import same_relation

#: Lines and radii shorter than this part of the sketch's size have no direction.
SMALLEST = 1e-9
#: A line of this part of the sketch's size has collapsed in a solve.
COLLAPSED = 1e-8


def check_extent(kind: str, numbers: list[float], size: float) -> None:
    """Refuse a line without length, a circle without radius, an arc without sweep.

    Raises
    ------
    AraelError
        E1220
    """
    least = SMALLEST * size
    if kind == "line":
        _least(kind, "length", math.dist(numbers[:2], numbers[2:]), least)
    elif kind in ("circle", "arc"):
        _least(kind, "radius", numbers[-1], least)
    elif kind in ("ellipse", "earc"):
        _least(kind, "radius", numbers[-3], least)
        _least(kind, "second radius", numbers[-2], least)
    elif kind in ("bezier", "bspline"):
        spread = max(math.dist(numbers[:2], numbers[i : i + 2]) for i in range(2, len(numbers), 2))
        _least(kind, "extent", spread, least)


def _least(kind: str, what: str, found: float, least: float) -> None:
    if not found > least:
        raise AraelError(
            Diagnostic(
                "E1220",
                f"a {kind} needs a {what} above zero, found {found:g}",
                help=("give it points that are apart",),
            )
        )


def check_left(document: Document, names: Iterable[str], cause: str = "") -> None:
    """Refuse a solution in which the ends of a line have come together.

    Parameters
    ----------
    names : of entities that have moved
    cause : what was asked for, in words

    Raises
    ------
    AraelError
        E1220
    """
    entities = document.entities
    lines = [one for one in map(entities.__getitem__, names) if one.kind == "line"]
    if not lines:
        return
    at = np.fromiter((one.at for one in lines), np.int64, len(lines))
    numbers = document.values[at[:, None] + np.arange(4)]
    length = np.hypot(numbers[:, 2] - numbers[:, 0], numbers[:, 3] - numbers[:, 1])
    short = np.flatnonzero(length <= 1e-5 * np.abs(numbers).max(axis=1))
    if not len(short):
        return
    # the sketch's size takes a while
    least = COLLAPSED * size_of(document)
    for k in short:
        if length[k] <= least:
            subject = f"`{cause}`" if cause else "this"
            name = lines[k].name
            raise AraelError(
                Diagnostic(
                    "E1220",
                    f"{subject} would leave nothing of `{name}`: its ends come together",
                    notes=("the sketch is left as it was",),
                    help=(f"`info {name}` lists what holds it",),
                )
            )


def check_new_constraint(document: Document, kind: str, args: tuple[str, ...]) -> None:
    """Refuse a relation that is there already; AraelError E1221 with its name."""
    for other in document.constraints.values():
        if other.kind == kind and same_relation(kind, args, other.args):
            raise _duplicate(kind, args, other)


def _duplicate(kind: str, args: tuple[str, ...], other: Constraint) -> AraelError:
    state = "" if other.active else ", switched off"
    return AraelError(
        Diagnostic(
            "E1221",
            f"`{kind} {' '.join(args)}` is there already: `{other.name}`{state}",
            help=("`delete " + other.name + "` takes it out",),
        )
    )


def same_dimension(document: Document, kind: str, args: tuple[str, ...]) -> Dimension | None:
    """A dimension of the same quantity, which a new value replaces."""
    return next(
        (
            one
            for one in document.dimensions.values()
            if one.kind == kind and same_relation(kind, args, one.args)
        ),
        None,
    )


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
