"""Angles in data that are more likely degrees than radians."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.model_warnings import DataWarning
from arael.diagnostics.records import Diagnostic

if TYPE_CHECKING:
    from arael.runtime.layout import Column
    from arael.runtime.store.store import Store
    from arael.runtime.store.table import Table

_MOST = 720.0
"""Largest angle in degrees that data have: two turns."""


def warn_of_degrees(store: Store) -> bool:
    """Warn of angles beyond a full turn, once for each field: W0702.

    Headings that were added up along a trajectory are angles beyond a full turn as well. They grow
    by less than half a turn from row to row, from one within a full turn.

    Returns
    -------
    Whether there were any angles.
    """
    any_rows = False
    for path, column in store.layout.angles:
        table = store.tables[path]
        rows = np.flatnonzero(table.present(column.path))
        if not len(rows):
            continue
        any_rows = True
        values = np.asarray(table.column(column.path), dtype=np.float64)[rows]
        values = values.reshape(len(rows), -1)
        far = _unexplained(values)
        if len(far) and np.abs(values).max() <= _MOST:
            _warn(table, column, rows[far], values[far])
    return any_rows


def _unexplained(values: NDArray[np.float64]) -> NDArray[np.intp]:
    """Rows (n, k) with an angle beyond a full turn that rows before it do not lead up to."""
    turn = 2 * math.pi * (1 + 1e-6)
    beyond = np.abs(values) > turn
    if not beyond.any():
        return np.zeros(0, dtype=np.intp)
    jumps = np.ones(values.shape, dtype=bool)
    jumps[1:] = np.abs(np.diff(values, axis=0)) >= math.pi
    wrong = np.zeros(len(values), dtype=bool)
    for k in range(values.shape[1]):
        run = np.cumsum(jumps[:, k]) - 1
        explained = np.zeros(run[-1] + 1, dtype=bool)
        explained[run[~beyond[:, k]]] = True
        wrong |= beyond[:, k] & ~explained[run]
    return np.flatnonzero(wrong)


def _warn(table: Table, column: Column, rows: NDArray[Any], values: NDArray[np.float64]) -> None:
    # Imported here for start-up time: few models are asked about.
    from arael.diagnostics.render import render

    row, angles = int(rows[0]), values[0]
    angle = float(angles[np.argmax(np.abs(angles))])
    place = f"{table.row_name(row)}.{column.path}" if table.layout.path else column.path
    if table.layout.key:
        place += f" (`{table.layout.key}` {table.column(table.layout.key)[row]!r})"
    remedy = f"give it in radians: {angle:g} degrees are {math.radians(angle):.6g}"
    if column.role == "data":
        name = column.path.rpartition(".")[2]
        remedy += f"; or declare `{name}: real [deg]` and write `deg2rad({name})` in the model"
    more = f"; {len(rows) - 1} more rows are alike" if len(rows) > 1 else ""
    found = Diagnostic(
        "W0702",
        f"an angle of {angle:g} rad: degrees?",
        origin=place,
        severity="warning",
        notes=(f"`{column.type}` is in radians (declared at {column.where}){more}",),
        help=(remedy,),
    )
    warnings.warn(render([found]).rstrip("\n"), DataWarning, stacklevel=4)
