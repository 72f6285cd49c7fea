import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.runtime.interruption import Interruption
from arael.runtime.levels.outcome import Outcome
from arael.runtime.levels.rows import Rows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_] | None

PIVOT_TOLERANCE: float

class Levels:
    rows: Rows
    soft: Rows | None
    guards: Rows | None
    scales: Array | None
    pivot_tolerance: float
    limit: int
    rounds: int
    factors: int
    linearisations: int
    interruption: Interruption
    def __init__(
        self,
        rows: Rows,
        soft: Rows | None = None,
        *,
        guards: Rows | None = None,
        scales: ArrayLike | None = None,
        step_limit: int = 100,
        pivot_tolerance: float = ...,
        interruption: Interruption | None = None,
    ) -> None: ...
    def interrupt(self) -> None: ...
    @property
    def components(self) -> int: ...
    @property
    def component_of(self) -> NDArray[np.int32]: ...
    def redundant(self) -> NDArray[np.int32]: ...
    def solve(
        self,
        x: Array,
        tolerance: ArrayLike = 1e-10,
        *,
        fixed: Mask = None,
        active: Mask = None,
        basic: Mask = None,
        touched: ArrayLike | None = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        keep: bool = False,
    ) -> Outcome: ...
    def minimise(
        self,
        x: Array,
        tolerance: ArrayLike = 1e-10,
        *,
        home: ArrayLike | None = None,
        soft_tolerance: float | None = None,
        fixed: Mask = None,
        active: Mask = None,
        basic: Mask = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        limit: int = 100,
    ) -> Outcome: ...
    def drag(
        self,
        x: Array,
        at: ArrayLike,
        target: ArrayLike,
        home: ArrayLike | None = None,
        tolerance: ArrayLike = 1e-10,
        *,
        fixed: Mask = None,
        active: Mask = None,
        basic: Mask = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        limit: int = 60,
        seconds: float | None = None,
    ) -> Outcome: ...
