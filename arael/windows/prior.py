"""The prior that rows leave behind: a dense linear residual in tangent coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.geometry.charts import chart_derivative
from arael.geometry.differences import CURVED, difference

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Part:
    """One parameter of a prior: its kind, its first estimate (stored,), its tangent scalars."""

    kind: str
    base: Floats
    tangent: int


class Prior:
    """Residuals ``residual + jacobian (x boxminus x0)`` of what left a model.

    A function of `Model.add_residuals` with one instance for each row of the Jacobian. The
    Jacobian by ``x boxminus x0`` never changes. Derivatives by a step at x contain the derivative
    of boxminus there: the inverse of `arael.geometry.charts.chart_derivative`.

    Attributes
    ----------
    parts : the parameters in their order, with their first estimates x0
    jacobian : (k, n) square root of the information, over all tangent scalars
    residual : (k,) at x0
    constant : cost of what left that no parameter changes; not part of the cost of the model
    undetermined : directions of the rows that left last which no residual determined
    """

    is_prior = True

    def __init__(
        self,
        parts: Sequence[Part],
        jacobian: Floats,
        residual: Floats,
        constant: float = 0.0,
        undetermined: int = 0,
    ) -> None:
        self.parts = tuple(parts)
        self.jacobian, self.residual = jacobian, residual
        self.constant, self.undetermined = constant, undetermined
        ends = np.cumsum([part.tangent for part in self.parts])
        # (k, 1, tangent) views: an instance has one residual.
        self._blocks = np.split(jacobian[:, None, :], ends[:-1], axis=2)
        alike: dict[tuple[str, int], list[int]] = {}
        for k, part in enumerate(self.parts):
            alike.setdefault((part.kind, len(part.base)), []).append(k)
        # Parts of one kind together: their numbers, first estimates and columns of the Jacobian.
        self._alike = [
            (
                kind,
                numbers,
                np.stack([self.parts[k].base for k in numbers]),
                np.concatenate(
                    [np.arange(ends[k] - self.parts[k].tangent, ends[k]) for k in numbers]
                ),
            )
            for (kind, _), numbers in alike.items()
        ]

    @property
    def information(self) -> Floats:
        """(n, n) information matrix J'J in tangent coordinates at the first estimates."""
        found: Floats = self.jacobian.T @ self.jacobian
        return found

    def __call__(self, *values: Any, row: Any) -> tuple[Floats, list[Floats]]:
        """Residuals (k,) and Jacobians (k, 1, tangent) by a step of each parameter."""
        moved, found = np.empty(self.jacobian.shape[1]), list(self._blocks)
        for kind, numbers, bases, columns in self._alike:
            at = np.concatenate([np.ravel(values[k][:1]) for k in numbers])
            delta = difference(kind, bases, at.astype(np.float64, copy=False).reshape(bases.shape))
            moved[columns] = delta.ravel()
            if kind in CURVED:
                back = np.linalg.inv(chart_derivative(kind, bases, delta))
                for k, one in zip(numbers, back, strict=True):
                    found[k] = found[k] @ one
        return self.residual + self.jacobian @ moved, found

    def __repr__(self) -> str:
        return f"<prior of {len(self.residual)} residuals over {len(self.parts)} parameters>"
