"""Rows that hold exactly: their products, and the loop of a solve."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.config import LmConfig
from arael.runtime.evaluation.compiled import Evaluation
from arael.runtime.linear.compiled import LinearSolver

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

class RowTable:
    count: int
    group_rows: int
    entries: int
    size: int
    value_count: int
    colours: int
    is_curved: bool
    row: Ints
    column: Ints
    equal: NDArray[np.uint8]
    def __init__(
        self,
        evaluation: Evaluation,
        structure: Any,
        groups: Sequence[tuple[int, int, Ints, bool, bool]],
        bounds: tuple[Any, ...],
    ) -> None: ...
    def evaluate(self) -> tuple[Floats, Floats]: ...
    def sizes(self) -> Floats: ...
    def times(self, entries: Floats, x: Floats) -> Floats: ...
    def transposed(self, entries: Floats, y: Floats) -> Floats: ...
    def lengths(self, entries: Floats, scale: Floats) -> Floats: ...
    def squared(self, entries: Floats, weights: Floats) -> Floats: ...
    def curvature(self, weights: Floats, entries: Floats) -> Floats: ...
    def violations(self, values: Floats) -> Floats: ...
    def settle(self, multipliers: Floats, tolerance: Floats) -> None: ...

class Exact:
    accepted: int
    start_cost: float
    damping: float
    current_cost: float
    multipliers: Floats
    scale: Floats
    tolerance: Floats
    history: NDArray[Any]
    gradient: Floats
    diagonal: Floats
    def __init__(
        self,
        evaluation: Evaluation,
        rows: RowTable,
        solver: LinearSolver,
        config: LmConfig,
        watcher: Any,
        watched: bool,
        curvature_of_residuals: Callable[[], RowTable] | None = None,
    ) -> None: ...
    def run(self) -> str: ...
    def can_hold(self, counted: Floats, scale: Floats) -> bool: ...
