"""The equations of a layout as one sparse matrix, with who owns each row and column."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arael.sketch.layout.layout import Layout

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class System:
    """Rows that act and columns that are unknown, at one place.

    Attributes
    ----------
    indptr, indices, entries : the Jacobian, compressed by rows
    residuals : (m,)
    owners : name of the constraint, dimension or entity of each row
    rows : (m,) numbers of the rows in the layout
    columns : (n,) columns of the layout
    column_of : by offset in the document's values, the column here; -1 for what is fixed
    place : (columns of the layout,) unknowns at which this was evaluated
    """

    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    entries: Floats
    residuals: Floats
    owners: list[str]
    rows: Ints
    columns: Ints
    column_of: Ints
    place: Floats
    by_owner: dict[str, list[int]] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return len(self.owners), len(self.columns)

    def rows_of(self, name: str) -> Ints:
        """Rows of a constraint, dimension or entity."""
        if not self.by_owner and self.owners:
            for row, owner in enumerate(self.owners):
                self.by_owner.setdefault(owner, []).append(row)
        return np.array(self.by_owner.get(name, ()), dtype=np.int64)


def system_of(layout: Layout, place: Floats | None = None, without: str = "") -> System:
    """The equations of a layout.

    Parameters
    ----------
    place : unknowns; those of the document if None
    without : leave the rows of this constraint or dimension out
    """
    here = layout.gather().copy() if place is None else place
    residuals, entries = layout.rows.jacobian(here)
    indptr, indices = layout.rows.indptr, layout.rows.indices
    owner = layout.owner
    rows = np.array(
        [row for row in layout.equations() if owner[row] != without],
        dtype=np.int64,
    )
    counts = np.diff(indptr)[rows]
    starts = np.zeros(len(rows) + 1, dtype=np.int32)
    np.cumsum(counts, out=starts[1:])
    taken = np.repeat(indptr[rows] - starts[:-1], counts) + np.arange(starts[-1])
    columns = layout.unknowns
    inside = np.full(max(len(here), 1), -1, dtype=np.int64)
    inside[columns] = np.arange(len(columns))
    return System(
        starts,
        inside[indices[taken]].astype(np.int32),
        entries[taken],
        residuals[rows],
        [owner[row] for row in rows],
        rows,
        columns,
        _column_of(layout, inside),
        here,
    )


def _column_of(layout: Layout, inside: Ints) -> Ints:
    roots = layout.roots()
    found = np.full(len(roots), -1, dtype=np.int64)
    free = roots >= 0
    found[free] = inside[roots[free]]
    return found
