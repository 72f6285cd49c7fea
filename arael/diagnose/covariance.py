"""Covariance of the solution by a dense inverse: for problems of some thousand parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

# A row of the model: a ref (`poses[3]` of the Python face), its name, or (path of the table, row).
Where = Any


class Covariance:
    """Covariance ``2 H^-1`` of all scalars that move, H = 2 J'J at the present values.

    What is kept fixed has no variance. A `where` is a ref (``path.landmarks[4]``), the name of a
    row or of a parameter (``"poses[3]"``, ``"poses[3].pos"``), or a pair (path of the table, row).

    Attributes
    ----------
    matrix : (n, n)
    names : (n,) names of its rows and columns
    """

    def __init__(self, matrix: Floats, names: list[str], problem: Problem) -> None:
        self.matrix = matrix
        self.names = names
        self._problem = problem

    def marginal(self, where: Where) -> Floats:
        """(k, k) covariance of the scalars of an entity or of one parameter."""
        found = self._scalars(where)
        return self.matrix[np.ix_(found, found)]

    def cross(self, a: Where, b: Where) -> Floats:
        """(k, l) covariance between the scalars of `a` and those of `b`."""
        return self.matrix[np.ix_(self._scalars(a), self._scalars(b))]

    def relative(self, a: Where, b: Where) -> Floats:
        """(k, k) covariance of the difference a - b: ``C_aa - C_ab - C_ba + C_bb``.

        Of the scalars that bear the same name in both (``pos.x``): a landmark relative to a pose is
        the difference of their positions.
        """
        of_a, of_b = self._local_names(a), self._local_names(b)
        common = [name for name in of_a if name in of_b]
        if not common:
            raise AraelError(
                Diagnostic(
                    "E1009",
                    f"`{_shown(a)}` and `{_shown(b)}` have no parameter of the same name",
                    origin="covariance",
                    notes=(f"they have {', '.join(of_a)} and {', '.join(of_b)}",),
                )
            )
        i, j = [of_a[name] for name in common], [of_b[name] for name in common]
        c = self.matrix
        return c[np.ix_(i, i)] - c[np.ix_(i, j)] - c[np.ix_(j, i)] + c[np.ix_(j, j)]

    def __repr__(self) -> str:
        return f"<Covariance of {len(self.names)} parameters>"

    def _name(self, where: Where) -> str:
        if isinstance(where, str):
            return where
        if isinstance(where, tuple):
            path, row = where
        else:
            path, row = where._table.layout.path, where._table.row_of(where._handle)
        return str(self._problem.store.tables[path].row_name(row)) if path else ""

    def _scalars(self, where: Where) -> list[int]:
        return list(self._local_names(where).values())

    def _local_names(self, where: Where) -> dict[str, int]:
        """Names within `where` of its scalars, and their columns."""
        name = self._name(where)
        if not name:
            entities = self._problem.layout.entities
            own = {e.prefix + t for e in entities if not e.table for t in e.tangent_names}
            found = {n: i for i, n in enumerate(self.names) if n in own}
        else:
            head = f"{name}."
            found = {n[len(head) :]: i for i, n in enumerate(self.names) if n.startswith(head)}
            if name in self.names:
                found[""] = self.names.index(name)
        if not found:
            raise AraelError(
                Diagnostic(
                    "E1009",
                    f"`{name}` is not solved for, so it has no covariance",
                    origin="covariance",
                    help=("it is fixed, frozen or absent, or the name is misspelt",),
                )
            )
        return found


def covariance(problem: Problem) -> Covariance:
    """Invert the Gauss-Newton Hessian.

    Raises
    ------
    SolveError
        E1008: the system is singular; the free directions are named.
    """
    names = problem.parameter_names()
    hessian = problem.hessian()
    diagonal = np.diag(hessian).copy()
    diagonal[diagonal == 0] = 1
    # Unit diagonal first, so that metres and radians are measured alike.
    scale = 1 / np.sqrt(diagonal)
    scaled = hessian * scale[:, None] * scale[None, :]
    if not np.isfinite(scaled).all():
        raise SolveError(
            Diagnostic("E1008", "the Hessian has non-finite entries", origin=problem.layout.name)
        )
    values, vectors = np.linalg.eigh(scaled)
    epsilon = 1.2e-7 if problem.layout.precision == "f32" else 2.2e-16
    free = values <= max(len(values), 1) * epsilon * max(float(values[-1]) if len(values) else 0, 1)
    if free.any():
        raise SolveError(_singular(names, vectors[:, free], problem))
    half = vectors / np.sqrt(values)
    matrix = 2 * (half @ half.T) * scale[:, None] * scale[None, :]
    return Covariance(matrix, names, problem)


def _singular(names: list[str], directions: Floats, problem: Problem) -> Diagnostic:
    count = directions.shape[1]
    shown = []
    for k in range(min(count, 3)):
        weight = np.abs(directions[:, k])
        strongest = np.argsort(-weight, kind="stable")[:3]
        parts = [f"{directions[i, k]:+.2f} {names[i]}" for i in strongest if weight[i] > 0.05]
        shown.append(f"free direction: {' '.join(parts)}" + (" ..." if len(names) > 3 else ""))
    return Diagnostic(
        "E1008",
        f"the system is singular: {count} of {len(names)} directions are free",
        origin=problem.layout.name,
        notes=tuple(shown),
        help=("add measurements or a prior that fix them, or fix a parameter (an anchor pose)",),
    )


def _shown(where: Where) -> str:
    return where if isinstance(where, str) else str(getattr(where, "name", where))
