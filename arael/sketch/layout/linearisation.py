"""The whole system without gaps: its numbering, and its residuals and Jacobian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Linearisation:
    """Residuals and Jacobian of a sketch, without gaps.

    Attributes
    ----------
    x : (n,) unknowns
    residuals : (m,) lengths
    indptr, indices, entries : the Jacobian in CSR
    rows : (m,) rows of the layout
    names : of the record of each row of the layout, as the layout has them now
    """

    x: NDArray[np.float64]
    residuals: NDArray[np.float64]
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    entries: NDArray[np.float64]
    rows: NDArray[np.int64]
    names: list[str]

    @property
    def owners(self) -> list[str]:
        """Name of the record of each row: a constraint, a dimension, or an entity with equations.

        Valid until the layout changes.
        """
        return [self.names[row] for row in self.rows.tolist()]

    def owner(self, row: int) -> str:
        """The same of one row."""
        return self.names[int(self.rows[row])]


@dataclass(frozen=True, slots=True)
class Numbering:
    """Numbering of unknowns and equations.

    Attributes
    ----------
    version : of the layout
    unknowns : index in `x` by column
    column : the reverse; -1 where nothing is unknown
    column_of : column by offset in the document's values
    rows : row of `rows` by equation
    number : the reverse
    is_range : by equation
    slacks : how many of the last columns are slacks of ranges
    """

    version: int
    unknowns: NDArray[np.int64]
    column: NDArray[np.int64]
    column_of: NDArray[np.int64]
    rows: NDArray[np.int64]
    number: NDArray[np.int64]
    is_range: NDArray[np.bool_]
    slacks: int
