"""Bounds of the scalars of a system: those of rows where the data sets them, else of the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.layout import Column, Entity, has_some
from arael.runtime.store.access import Array, Bools, Ints, StoreLike, TableLike
from arael.runtime.store.bounds import of_model

if TYPE_CHECKING:
    from arael.runtime.system import System

Floats = NDArray[np.float64]


def ends_of(table: TableLike, column: Column) -> tuple[Floats | None, Floats | None]:
    """Lower and upper bounds (rows, tangent) of a parameter; (1, tangent) where all are the same.

    None for an end that is open in all rows.
    """
    param = column.param
    if param is None or param.kind not in ("real", "vec"):
        return None, None
    found: list[Floats | None] = []
    for end, of_layout in (("low", param.low), ("high", param.high)):
        own = table.bound(column.path, end)
        if own is not None:
            found.append(np.asarray(own, dtype=np.float64).reshape(table.size, param.tangent))
        elif has_some(of_layout):
            found.append(of_model(column, end).reshape(1, param.tangent))
        else:
            found.append(None)
    return found[0], found[1]


def has_bounds(store: StoreLike, entity: Entity, of_model: bool) -> bool:
    """Whether the scalars of an entity have bounds, by the model (`Layout.bounded`) or in rows."""
    return of_model or store.tables[entity.table].bounds_version != ()


def bounds_of_scalars(
    store: StoreLike, entity: Entity, rows: Ints, count: int, moves: Bools
) -> tuple[Floats, Floats]:
    """Bounds (count * tangent,) of the scalars of an entity's rows, infinite where open or held.

    Parameters
    ----------
    rows, count : those in the system, and how many they are
    moves : (rows of the table, tangent) which scalars move
    """
    table = store.tables[entity.table]
    own = store.layout.table(entity.table)
    ends = [ends_of(table, own.column(use.column)) for use in entity.params]
    if all(low is None and high is None for low, high in ends):
        return all_open(count * entity.tangent)
    found = []
    for end, open_end in enumerate((-np.inf, np.inf)):
        bounds = np.full((count, entity.tangent), open_end)
        some = False
        for use, both in zip(entity.params, ends, strict=True):
            one = both[end]
            if one is not None:
                some = True
                at = slice(use.tangent_start, use.tangent_start + use.tangent)
                bounds[:, at] = one if len(one) == 1 else one[rows]
        if some and not moves.all():
            bounds[~moves[rows]] = open_end
        found.append(bounds.ravel())
    return found[0], found[1]


def all_open(count: int) -> tuple[Floats, Floats]:
    """Bounds of scalars that have none."""
    both = np.empty((2, count))
    both[0] = -np.inf
    both[1] = np.inf
    return both[0], both[1]


@dataclass(frozen=True)
class Bounded:
    """The bounded scalars of one entity that move.

    Attributes
    ----------
    entity : its number
    scalars : (n,) scalars of the system
    at : (n,) their offsets in the state array of the entity
    low, high : (n,) bounds, infinite where open
    """

    entity: int
    scalars: Ints
    at: Ints
    low: Floats
    high: Floats


def bounded_of(number: int, entity: Entity, first: Ints, low: Floats, high: Floats) -> Bounded:
    """The bounded scalars of an entity, from the bounds of all its scalars in the system.

    Parameters
    ----------
    first : (rows,) first scalar of each row, -1 where it is not in the system
    """
    rows = np.flatnonzero(first >= 0)
    which = np.flatnonzero((low != -np.inf) | (high != np.inf))  # NaN too, which is an error
    stored = np.zeros(entity.tangent, dtype=np.int64)
    for use in entity.params:
        if use.stored == use.tangent:
            at = slice(use.tangent_start, use.tangent_start + use.tangent)
            stored[at] = np.arange(use.stored_start, use.stored_start + use.stored)
    row, tangent = rows[which // entity.tangent], which % entity.tangent
    return Bounded(
        number,
        first[row] + tangent,
        row * entity.state + stored[tangent],
        low[which],
        high[which],
    )


def check_start(system: System, states: Sequence[Array]) -> None:
    """Check that scalars that move start within their bounds.

    Raises
    ------
    SolveError
        E1007 a value outside; E0730 bounds that leave no value, or are NaN.
    """
    for one in system.bounded:
        values = states[one.entity].reshape(-1)[one.at]
        low, high = one.low.astype(values.dtype), one.high.astype(values.dtype)
        inside = (values >= low) & (values <= high)
        if not inside.all():
            k = int(np.argmin(inside))
            raise SolveError(_outside(system, one, k, float(values[k])))


def _outside(system: System, one: Bounded, k: int, value: float) -> Diagnostic:
    scalar = int(one.scalars[k])
    name = system.name_of(scalar)
    entity = system.layout.entities[one.entity]
    _, _, tangent = system.owner(scalar)
    use = next(u for u in entity.params if u.tangent_start <= tangent < u.tangent_start + u.tangent)
    low, high = float(one.low[k]), float(one.high[k])
    where = system.layout.table(entity.table).column(use.column).where
    if not low <= high:
        why = "are not numbers" if np.isnan(low + high) else "leave no value"
        return Diagnostic(
            "E0730",
            f"the bounds {low:g} .. {high:g} of `{name}` {why}",
            origin=where,
            help=("set `low` below `high`; None is no bound",),
        )
    table = system.store.tables[entity.table]
    own = any(table.bound(use.column, end) is not None for end in ("low", "high"))
    return Diagnostic(
        "E1007",
        f"`{name}` starts at {value:g}, outside its bounds {low:g} .. {high:g}",
        origin=where,
        help=(f"start it inside, or widen the bounds{'' if own else ' in the model'}",),
    )


def keep_inside(system: System, states: Sequence[Array]) -> None:
    """Put what moves within bounds to the last bit; a step onto a bound may end a rounding beyond.

    Fixed values may be outside, and stay.
    """
    for one in system.bounded:
        flat = states[one.entity].reshape(-1)
        flat[one.at] = np.clip(flat[one.at], one.low, one.high)
