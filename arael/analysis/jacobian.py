"""The Jacobian by rows, for counting degrees of freedom and finding bad residuals."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

MOST_ROWS, MOST_COLUMNS = 20, 8
"""Largest Jacobian that a notebook shows whole; of others it shows a line for each constraint."""


@dataclass(frozen=True)
class JacobianRow:
    """One residual.

    Attributes
    ----------
    residual : its value
    label : its constraint, ``PointFrine.bearing``
    constraint : number of the constraint's instance, the value of its ``constraint_index`` field
    entries : (column, value) of each derivative, columns ascending
    """

    residual: float
    label: str
    constraint: int
    entries: tuple[tuple[int, float], ...]

    @property
    def is_finite(self) -> bool:
        """Whether the residual and all its derivatives are finite."""
        return bool(np.isfinite([self.residual, *(value for _, value in self.entries)]).all())


class Svd(NamedTuple):
    """Singular value decomposition ``J = u diag(s) v[:, :k]'``.

    Attributes
    ----------
    u : (m, k) with k = min(m, n)
    s : (k,) singular values, descending
    v : (n, n) right singular vectors as columns; those of singular values near 0, and those beyond
        k, are the directions in which no residual changes
    """

    u: Floats
    s: Floats
    v: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Jacobian(Displayed):
    """Derivatives of all residuals by all free scalars; f64 for models of either precision.

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
    _problem: Problem | None = field(default=None)

    @property
    def shape(self) -> tuple[int, int]:
        """Residuals and columns."""
        return len(self.residuals), len(self.names)

    def __len__(self) -> int:
        return len(self.residuals)

    def __getitem__(self, index: int) -> JacobianRow:
        index = _number(index, "index")
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

    def _sheet(self) -> Sheet:
        title = repr(self).strip("<>")
        if self.shape[0] <= MOST_ROWS and self.shape[1] <= MOST_COLUMNS:
            whole = [
                (self.labels[self.label_of[k]], f"{residual:.4g}", *(f"{v:.4g}" for v in row))
                for k, (residual, row) in enumerate(zip(self.residuals, self.dense(), strict=True))
            ]
            return Sheet(title, ("constraint", "residual", *self.names), whole)
        rows = []
        for number, label in enumerate(self.labels):
            mine = np.flatnonzero(self.label_of == number)
            if len(mine):
                part = self.matrix[mine]
                largest = float(np.abs(part.data).max(initial=0.0))
                rows.append((label, str(len(mine)), str(part.nnz), f"{largest:.3g}"))
        return Sheet(title, ("constraint", "residuals", "entries", "largest derivative"), rows)

    @property
    def rows(self) -> list[JacobianRow]:
        """All rows."""
        return list(self)

    def dense(self) -> Floats:
        """(m, n)."""
        found: Floats = self.matrix.toarray()
        return found

    def of(self, label: str) -> Jacobian:
        """The rows of one constraint only (``"PointFrine.bearing"``); KeyError if there is none."""
        if not isinstance(label, str):
            raise wrong_argument("jacobian.of", "label", "the label of a constraint", label)
        if label not in self.labels:
            raise KeyError(f"no constraint {label!r}; there are {', '.join(self.labels)}")
        mine = np.flatnonzero(self.label_of == self.labels.index(label))
        return Jacobian(
            self.residuals[mine],
            self.constraint[mine],
            self.label_of[mine],
            self.labels,
            self.names,
            self.matrix[mine],
            self._problem,
        )

    def bad_rows(self) -> list[JacobianRow]:
        """Rows with a residual or a derivative that is not finite."""
        wrong = ~np.isfinite(self.residuals)
        entries = np.repeat(np.arange(len(self)), np.diff(self.matrix.indptr))
        wrong[entries[~np.isfinite(self.matrix.data)]] = True
        return [self[int(i)] for i in np.flatnonzero(wrong)]

    def instance(self, constraint: int) -> str:
        """A constraint's instance in words: ``PointFrine.bearing[17] at landmarks[5].frines[2]``.

        Parameters
        ----------
        constraint : the value of `JacobianRow.constraint` or of a ``constraint_index`` field
        """
        problem = self._problem
        assert problem is not None
        constraint = _number(constraint, "constraint")
        ends = np.cumsum([len(active) for active in problem.structure.active])
        if not 0 <= constraint < ends[-1]:
            raise IndexError(f"no constraint instance {constraint}; there are {ends[-1]}")
        group = bisect_right(ends.tolist(), constraint)
        row = constraint - (int(ends[group - 1]) if group else 0)
        return f"{problem.instance_name(group, row)} at {problem.instance_place(group, row)}"

    def sensitivities(self) -> Floats:
        """(n,) length of each column: by how many sigmas the residuals change per unit."""
        square = np.zeros(self.shape[1])
        np.add.at(square, self.matrix.indices, self.matrix.data**2)
        return np.sqrt(square)

    def singular_values(self) -> Floats:
        """Descending, min(m, n) of them; the number near zero is that of the free directions.

        By a dense decomposition in f64, for at most a few thousand columns.
        `arael.Model.free_directions` finds those near zero of larger problems.

        Raises AraelError (E1002), like `svd` and `rank`, if a derivative is not finite.
        """
        self._require_finite()
        return np.asarray(np.linalg.svd(self.dense(), compute_uv=False))

    def svd(self) -> Svd:
        """Singular values with their vectors, dense."""
        self._require_finite()
        u, s, vt = np.linalg.svd(self.dense(), full_matrices=self.shape[0] < self.shape[1])
        return Svd(u[:, : len(s)], s, vt.T)

    def rank(self) -> int:
        """Rank of the Jacobian; the number of columns minus this is that of the free directions.

        Columns are scaled to one length first, so that units do not matter.
        """
        self._require_finite()
        length = self.sensitivities()
        dense = self.dense() / np.where(length > 0, length, 1.0)
        s = np.linalg.svd(dense, compute_uv=False)
        single = self._problem is not None and self._problem.layout.precision == "f32"
        epsilon = np.finfo(np.float32 if single else np.float64).eps
        largest = s.max(initial=0.0)
        return int(np.count_nonzero(s > max(dense.shape) * epsilon * largest))

    def _require_finite(self) -> None:
        """Raise E1002 for the first derivative that is not finite, by its row and its column."""
        bad = np.flatnonzero(~np.isfinite(self.matrix.data))
        if not len(bad):
            return
        at = int(bad[0])
        row = int(np.searchsorted(self.matrix.indptr, at, side="right")) - 1
        label = self.labels[self.label_of[row]]
        place = label if self._problem is None else self.instance(int(self.constraint[row]))
        rows = len(self.bad_rows())
        raise AraelError(
            Diagnostic(
                "E1002",
                f"row {row} of the Jacobian, `{place}`: the derivative by "
                f"`{self.names[self.matrix.indices[at]]}` is {self.matrix.data[at]:g}",
                origin=label,
                notes=("singular values and rank need finite numbers",),
                help=(
                    f"`bad_rows()` lists {'this row' if rows == 1 else f'all {rows} such rows'}",
                ),
            )
        )

    def __repr__(self) -> str:
        m, n = self.shape
        return f"<Jacobian {m} residuals x {n} parameters, {self.matrix.nnz} entries>"


def jacobian(problem: Problem) -> Jacobian:
    """The Jacobian at the accepted state; rows by constraint, instance, residual."""
    # imported here: start-up time
    from scipy.sparse import coo_array

    free = problem.free
    plan = problem.structure.plan
    column_of = np.full(problem.size + plan.trash, -1, dtype=np.int64)
    column_of[free] = np.arange(len(free))
    labels = list(dict.fromkeys(g.label for g in problem.layout.groups if not g.require))
    residuals, constraint, label_of = [], [], []
    rows, columns, values = [], [], []
    first_row = first_instance = 0
    for number, group in enumerate(problem.layout.groups):
        acting = np.flatnonzero(problem.evaluation.acting(number))
        if group.require:  # no part of the cost
            first_instance += len(plan.active[number])
            continue
        n, m = len(acting), group.residuals
        found, entries = problem.evaluation.group_rows(number)
        found, entries = found[acting], entries[acting]
        residuals.append(np.asarray(found, dtype=np.float64).ravel())
        constraint.append(np.repeat(first_instance + acting, m))
        label_of.append(np.full(n * m, labels.index(group.label)))
        placement = plan.placements[number]
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            rows.append(first_row + m * np.arange(n) + residual)
            columns.append(column_of[placement.gradient_at[acting, use] + tangent])
            values.append(np.asarray(entries[:, k], dtype=np.float64))
        first_row += n * m
        first_instance += len(plan.active[number])
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
        problem,
    )


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(parts) if parts else np.zeros(0)


def _number(given: Any, name: str) -> int:
    if isinstance(given, bool) or not isinstance(given, int | np.integer):
        raise wrong_argument("jacobian", name, "a whole number", given)
    return int(given)
