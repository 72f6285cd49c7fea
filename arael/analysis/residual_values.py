"""Residuals of one constraint, row by row: as measured, whitened, and after the loss.

Kernels compute residuals after the loss alone. The other two are derived from the text of the model
by `arael.residuals.unweighted`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.problem import Problem
from arael.runtime.system import row_names

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class ResidualValues:
    """Residuals of the instances of one constraint that act, in the order of its rows.

    Attributes
    ----------
    label : of the constraint, ``Sat.pseudorange``
    rows : (n,) the row of each instance, ``sats[3]``
    raw : (n, m) without factors of data alone at the front or the end of the residual, ``1 /
        sigma`` of ``(predicted - measured) / sigma``: in the unit of the measurement
    whitened : (n, m) as the model writes it, before the loss
    robust : (n, m) after the loss, as the solver sums their squares; `whitened` without one
    """

    label: str
    rows: tuple[str, ...]
    raw: Floats
    whitened: Floats
    robust: Floats

    @property
    def cost(self) -> Floats:
        """(n,) cost of each instance."""
        return np.asarray((self.robust**2).sum(axis=1))

    @property
    def weight(self) -> Floats:
        """(n,) share of its squared residual that each instance costs: 1 without a loss."""
        square = (self.whitened**2).sum(axis=1)
        return np.where(square > 0, self.cost / np.where(square > 0, square, 1.0), 1.0)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        n, m = self.robust.shape
        return f"<residuals of {self.label}: {n} instances of {m}>"


def residual_values(
    problem: Problem, label: str, unweighted: Callable[[int], tuple[Floats, Floats]]
) -> ResidualValues:
    """Residuals of the constraint `label` at the current values.

    Parameters
    ----------
    unweighted : raw and whitened residuals (rows, m) of the group of a number

    Raises
    ------
    AraelError
        E1037: no such constraint.
    """
    if not isinstance(label, str):
        raise wrong_argument("residual_values", "label", "the label of a constraint", label)
    groups = problem.layout.groups
    numbers = [k for k, one in enumerate(groups) if one.label == label and one.case_of < 0]
    if not numbers:
        known = list(dict.fromkeys(group.label for group in groups))
        near = closest(label, known)
        help_ = f"did you mean `{near[0]}`?" if near else f"there are {', '.join(known)}"
        raise _wrong(f"there is no constraint `{label}`", help_)
    parts = []
    for number in numbers:
        robust, acting, active = problem.constraint_rows(number)
        raw, whitened = unweighted(number)
        table = groups[number].table
        rows = tuple(row_names(problem.store, table, active[acting]))
        if not table:
            rows = (problem.layout.root,) * len(rows)
        if table.endswith("/rows"):  # added at run time
            rows = tuple(f"row {row}" for row in active[acting])
        parts.append((rows, raw[acting], whitened[acting], robust[acting]))
    rows_, *arrays = zip(*parts, strict=True)
    return ResidualValues(
        label,
        tuple(row for part in rows_ for row in part),
        *(np.concatenate(part).astype(np.float64) for part in arrays),
    )


def _wrong(message: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E1037", message, origin="residual_values", help=(advice,)))
