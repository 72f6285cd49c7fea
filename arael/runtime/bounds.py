"""Bounds of the scalars of a system: those of rows where the data sets them, else of the model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.layout import Column, Entity, ParamUse
from arael.runtime.store.access import Array, Bools, StoreLike, TableLike
from arael.runtime.store.bounds import of_model

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
        elif any(bound is not None for bound in of_layout):
            found.append(of_model(column, end).reshape(1, param.tangent))
        else:
            found.append(None)
    return found[0], found[1]


def bounds_of_scalars(
    store: StoreLike, entity: Entity, rows: NDArray[np.int64], moves: Bools
) -> tuple[Floats, Floats]:
    """Bounds (len(rows) * tangent,) of the scalars of an entity's rows, infinite where held.

    Parameters
    ----------
    rows : those in the system
    moves : (rows of the table, tangent) which scalars move
    """
    table = store.tables[entity.table]
    found = []
    own = store.layout.table(entity.table)
    ends = [ends_of(table, own.column(use.column)) for use in entity.params]
    for end, open_end in enumerate((-np.inf, np.inf)):
        bounds = np.full((len(rows), entity.tangent), open_end)
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


def check_start(
    store: StoreLike, entity: Entity, use: ParamUse, values: Array, free: Bools
) -> None:
    """Check that the free scalars of a parameter start within their bounds.

    Parameters
    ----------
    values, free : (rows, tangent) of the parameter

    Raises
    ------
    SolveError
        E1007 a value outside; E0728 bounds that leave no value, or are NaN.
    """
    table = store.tables[entity.table]
    column = store.layout.table(entity.table).column(use.column)
    low, high = ends_of(table, column)
    if low is None and high is None:
        return
    low = np.full((1, use.tangent), -np.inf) if low is None else low
    high = np.full((1, use.tangent), np.inf) if high is None else high
    low, high = np.broadcast_to(low, free.shape), np.broadcast_to(high, free.shape)
    inside = (values >= low.astype(values.dtype)) & (values <= high.astype(values.dtype))
    outside = free & ~inside
    if not outside.any():
        return
    row, k = (int(i) for i in np.argwhere(outside)[0])
    place = table.row_name(row)
    scalar = entity.prefix + entity.tangent_names[use.tangent_start + k]
    scalar = f"{place}.{scalar}" if place else scalar
    least, most = float(low[row, k]), float(high[row, k])
    own = any(table.bound(use.column, end) is not None for end in ("low", "high"))
    where = "" if own else " in the model"
    if not least <= most:
        raise SolveError(
            Diagnostic(
                "E0728",
                f"the bounds {least:g} .. {most:g} of `{scalar}` "
                + ("are not numbers" if np.isnan(least + most) else "leave no value"),
                origin=column.where,
                help=("set `low` below `high`; None is no bound",),
            )
        )
    raise SolveError(
        Diagnostic(
            "E1007",
            f"`{scalar}` starts at {float(values[row, k]):g}, "
            f"outside its bounds {least:g} .. {most:g}",
            origin=column.where,
            help=(f"start it inside, or widen the bounds{where}",),
        )
    )
