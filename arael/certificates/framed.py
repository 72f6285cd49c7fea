"""What all chordal problems have: unknowns that are columns of X, and their values in the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.certificates.quadratic import Frames
from arael.certificates.values import put_positions, put_rotations
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

_TINY = 1e-9
"""Cost of a residual, in squared sigmas, below which a gap is none."""


@dataclass(frozen=True, eq=False)
class FramedProblem:
    """Rotations and positions of a model as columns of X.

    Attributes
    ----------
    frames : where the unknowns lie
    exact : whether the cost is that of the model itself; else of its chordal twin
    residuals : number of residuals of the model
    """

    problem: Problem
    frames: Frames
    exact: bool
    residuals: int

    def scale(self, cost: float) -> float:
        """What a gap of a minimum of this cost is relative to."""
        return max(cost, _TINY * self.residuals)

    def values(self) -> Floats:
        """(d, size) X at the values of the model."""
        frames = self.frames
        x = np.zeros((frames.d, frames.size))
        x[:, : frames.d] = np.eye(frames.d)
        for (table, column), first in frames.rotation.items():
            rows = np.flatnonzero(first >= 0)
            at = first[rows, None] + np.arange(frames.d)
            x[:, at] = frames.values[table, column, "R"][rows].transpose(1, 0, 2)
        for (table, column), first in frames.position.items():
            rows = np.flatnonzero(first >= 0)
            x[:, first[rows]] = frames.values[table, column, "t"][rows].T
        return x

    def put(self, x: Floats) -> None:
        """Write X into the model, turned so that the axes of the world are its own."""
        frames, store = self.frames, self.problem.store
        x = x[:, : frames.d].T @ x
        for (table, column), first in frames.rotation.items():
            rows = np.flatnonzero(first >= 0)
            at = first[rows, None] + np.arange(frames.d)
            target = store.tables[table].column(column)
            put_rotations(kind_of(store, table, column), target, rows, x[:, at].transpose(1, 0, 2))
            store.tables[table].written()
        for (table, column), first in frames.position.items():
            rows = np.flatnonzero(first >= 0)
            target = store.tables[table].column(column)
            put_positions(kind_of(store, table, column), target, rows, x[:, first[rows]].T)
            store.tables[table].written()


def kind_of(store: Any, table: str, column: str) -> str:
    """Kind of a column of parameters."""
    return str(store.layout.table(table).column(column).param.kind)
