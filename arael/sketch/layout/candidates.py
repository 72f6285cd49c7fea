"""The equation that a constraint or dimension would be, without putting it into the document."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import KernelRows
from arael.sketch.document.records import Constraint, Dimension
from arael.sketch.layout import model, quantities, relations
from arael.sketch.layout.layout import Layout
from arael.sketch.layout.operands import operands


class Candidate(NamedTuple):
    """One equation at the document's numbers.

    Attributes
    ----------
    columns : (k,) unknowns that it reads
    entries : (k,) derivatives
    residual : a length
    """

    columns: NDArray[np.int64]
    entries: NDArray[np.float64]
    residual: float


class Candidates:
    """Equations of records that are not in the document.

    Parameters
    ----------
    layout : of the document
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._rows: KernelRows | None = None

    def of(self, record: Constraint | Dimension) -> Candidate | None:
        """The equation of a record.

        None if that takes more than one equation between unknowns: several of them, unknowns of
        its own, sums, fixed points.
        """
        layout = self.layout
        x = layout.gather()
        values = layout.document.values
        args = operands(layout.document, record.args)
        if isinstance(record, Dimension):
            plan = quantities.plan_of(record, args, values)
        else:
            plan = relations.plan_of(record, args, values, layout)
        if plan.sums or plan.hidden or len(plan.rows) != 1 or plan.impossible:
            return None
        (row,) = plan.rows
        uses = []
        for use in row.uses:
            at = layout.use_of(use) if isinstance(use, int) and use >= 0 else -1
            if at < 0:
                return None
            uses.append(at)
        rows = self._rows = self._rows or model.rows()
        if rows.n != layout.rows.n:
            rows.resize(layout.rows.n)
        if rows.tables[row.struct].residuals != 1:
            return None
        at = rows.add(row.struct, uses, layout.fields(row))
        try:
            residuals, entries = rows.jacobian(x)
            start, end = rows.indptr[at : at + 2]
            columns = layout.columns_at(rows.indices[start:end])
            return Candidate(columns, entries[start:end], float(residuals[at]))
        finally:
            rows.remove(at)
