"""The Jacobian by rows, for counting degrees of freedom and finding bad residuals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.problem import Problem

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class JacobianRow:
    """One residual.

    Attributes
    ----------
    residual : its value
    label : its constraint, ``PointFrine.bearing``
    constraint : number of the constraint's instance, as a ``constraint_index`` field receives it
    entries : (column, value) of each derivative, columns ascending
    """

    residual: float
    label: str
    constraint: int
    entries: tuple[tuple[int, float], ...]


@dataclass(frozen=True, eq=False, repr=False)
class Jacobian:
    """Derivatives of all residuals by all scalars that move; f64 whatever the model's precision.

    Attributes
    ----------
    residuals : (m,)
    constraint : (m,) number of each residual's constraint instance
    label_of : (m,) index of each residual's label in `labels`
    labels : labels in the order of the model
    names : (n,) names of the columns
    matrix : (m, n) scipy sparse array, CSR
    """

    residuals: Floats
    constraint: NDArray[np.int64]
    label_of: NDArray[np.int64]
    labels: tuple[str, ...]
    names: tuple[str, ...]
    matrix: Any

    @property
    def shape(self) -> tuple[int, int]:
        """Residuals and columns."""
        return len(self.residuals), len(self.names)

    def __len__(self) -> int:
        return len(self.residuals)

    def __getitem__(self, index: int) -> JacobianRow:
        if not -len(self) <= index < len(self):
            raise IndexError(f"row {index} of a Jacobian with {len(self)} rows")
        index %= len(self)
        part = slice(self.matrix.indptr[index], self.matrix.indptr[index + 1])
        columns, values = self.matrix.indices[part], self.matrix.data[part]
        return JacobianRow(
            float(self.residuals[index]),
            self.labels[self.label_of[index]],
            int(self.constraint[index]),
            tuple(zip(columns.tolist(), values.tolist(), strict=True)),
        )

    def __iter__(self) -> Iterator[JacobianRow]:
        return (self[i] for i in range(len(self)))

    @property
    def rows(self) -> list[JacobianRow]:
        """All rows."""
        return list(self)

    def dense(self) -> Floats:
        """(m, n)."""
        found: Floats = self.matrix.toarray()
        return found

    def singular_values(self) -> Floats:
        """Descending, min(m, n) of them; those near zero count the free directions."""
        return np.asarray(np.linalg.svd(self.dense(), compute_uv=False))

    def svd(self) -> tuple[Floats, Floats, Floats]:
        """Thin factors U (m, k), s (k,) and V (n, n).

        Columns of V beyond the rank are the directions in which no residual changes.
        """
        dense = self.dense()
        u, s, _ = np.linalg.svd(dense, full_matrices=False)
        vt = np.linalg.svd(dense, full_matrices=True)[2]
        return u, s, vt.T

    def __repr__(self) -> str:
        m, n = self.shape
        return f"<Jacobian {m} residuals x {n} parameters, {self.matrix.nnz} entries>"


def jacobian(problem: Problem) -> Jacobian:
    """The Jacobian at the accepted state; rows by constraint, instance, residual."""
    # Deferred: most solves never build one, and importing scipy.sparse takes a tenth of a second.
    from scipy.sparse import coo_array

    free = problem.free
    column_of = np.full(problem.size + problem.structure.trash, -1, dtype=np.int64)
    column_of[free] = np.arange(len(free))
    labels = list(dict.fromkeys(group.label for group in problem.layout.groups))
    residuals, constraint, label_of = [], [], []
    rows, columns, values = [], [], []
    first_row = first_instance = 0
    for number, group in enumerate(problem.layout.groups):
        n, m = len(problem.structure.active[number]), group.residuals
        found, entries = problem.evaluation.group_rows(number)
        residuals.append(np.asarray(found, dtype=np.float64).ravel())
        constraint.append(np.repeat(first_instance + np.arange(n), m))
        label_of.append(np.full(n * m, labels.index(group.label)))
        placement = problem.structure.placements[number]
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            rows.append(first_row + m * np.arange(n) + residual)
            columns.append(column_of[placement.gradient_at[:, use] + tangent])
            values.append(np.asarray(entries[:, k], dtype=np.float64))
        first_row += n * m
        first_instance += n
    row, column, value = _joined(rows), _joined(columns), _joined(values)
    kept = column >= 0
    matrix = coo_array(
        (value[kept], (row[kept].astype(np.int64), column[kept].astype(np.int64))),
        shape=(first_row, len(free)),
    ).tocsr()
    return Jacobian(
        _joined(residuals),
        _joined(constraint).astype(np.int64),
        _joined(label_of).astype(np.int64),
        tuple(labels),
        tuple(problem.parameter_names()),
        matrix,
    )


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(parts) if parts else np.zeros(0)
