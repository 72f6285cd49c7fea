"""What a record of a document contributes to the equations, before unknowns have places.

Numbers are named by their offset in ``document.values``; hidden unknowns of a record by ``-1 - k``
with ``k`` counting the numbers of `Plan.hidden`; a constant point by `Constant`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arael.sketch.expressions.gradient import Program

Values = NDArray[np.float64]
Data = Mapping[str, float | Sequence[float]]


@dataclass(frozen=True, slots=True)
class Constant:
    """A number, or the two of a point, that never changes."""

    numbers: tuple[float, ...]


Use = int | Constant


@dataclass(frozen=True, slots=True)
class Row:
    """One instance of a struct of ``models/sketch.arael``.

    Attributes
    ----------
    struct : its name
    uses : what its refs are, in the order of the model
    data : its fields; those that are absent keep the model's defaults
    """

    struct: str
    uses: tuple[Use, ...]
    data: Data = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Sum:
    """One equation: the sum of ``factor * residual`` of rows and of numbers, minus an offset.

    Where the offset follows geometry, it is a multiple of a program in place of a number.

    Attributes
    ----------
    parts : rows of one residual and a field `value` each, with their factors
    offset : what the sum is to be
    terms : numbers, with their factors
    program : what is subtracted, or None
    scale : by what it is multiplied
    """

    parts: tuple[tuple[Row, float], ...]
    offset: float = 0.0
    terms: tuple[tuple[int, float], ...] = ()
    program: Program | None = None
    scale: float = 1.0


@dataclass(frozen=True, slots=True)
class Hidden:
    """Unknowns that are not in the document.

    Attributes
    ----------
    names : one of each number, ``contact.x``
    start : the numbers, from those of the document
    low, high : bounds that hold for each of them
    is_point : whether they are a point, else one scalar
    """

    names: tuple[str, ...]
    start: Callable[[Values], Sequence[float]]
    low: float = -np.inf
    high: float = np.inf

    @property
    def is_point(self) -> bool:
        """Two numbers are a point, one is a scalar."""
        return len(self.names) == 2


@dataclass(frozen=True, slots=True)
class Setting:
    """Where a number of a dimension goes: the row's ``value = scale * number + shift``.

    Attributes
    ----------
    which : ``rows``, ``sums`` or ``guards``
    at : number of the row in there
    amount : which number of the dimension: ``value``, ``low`` or ``high``
    """

    which: str
    at: int
    amount: str
    scale: float = 1.0
    shift: float = 0.0


@dataclass(slots=True)
class Plan:
    """All a record contributes.

    Attributes
    ----------
    rows, sums : its equations
    guards : rows whose residual is to stay positive
    hidden : its own unknowns
    settings : what to change when only the value of a dimension does
    ties : points that are one place
    impossible : why the record can never hold, else empty
    piece : of a point on a spline of several pieces, else -1
    unguarded : whether a radius has no guard, since it was not above 0
    """

    rows: list[Row] = field(default_factory=list)
    sums: list[Sum] = field(default_factory=list)
    guards: list[Row] = field(default_factory=list)
    hidden: list[Hidden] = field(default_factory=list)
    settings: list[Setting] = field(default_factory=list)
    impossible: str = ""
    piece: int = -1
    unguarded: bool = False

    def hide(self, hidden: Hidden) -> int:
        """A hidden unknown; returns what rows use it by."""
        at = sum(len(one.names) for one in self.hidden)
        self.hidden.append(hidden)
        return -1 - at

    def add(self, struct: str, *uses: Use, **data: float | Sequence[float]) -> None:
        """An equation."""
        self.rows.append(Row(struct, uses, data))

    def guard(self, struct: str, *uses: Use, **data: float | Sequence[float]) -> None:
        """A number that is to stay positive."""
        self.guards.append(Row(struct, uses, data))
