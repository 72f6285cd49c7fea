from numpy.typing import ArrayLike, NDArray
import numpy as np

from arael.runtime.levels.outcome import Outcome
from arael.runtime.levels.rows import Rows

class Levels:
    rows: Rows
    guards: Rows | None
    factors: int
    def __init__(
        self,
        rows: Rows,
        guards: Rows | None = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
    ) -> None: ...
    def set_bounds(self, low: ArrayLike | None, high: ArrayLike | None) -> None: ...
    def forget(self) -> None: ...
    def solve(
        self,
        x: NDArray[np.float64],
        tolerance: ArrayLike,
        active: NDArray[np.bool_] | None = None,
        most: int = 100,
    ) -> Outcome: ...
    @property
    def state_of_unknowns(self) -> NDArray[np.float64]: ...
    @property
    def residuals(self) -> NDArray[np.float64]: ...
    def drag(
        self,
        x: NDArray[np.float64],
        at: ArrayLike,
        targets: ArrayLike,
        home: NDArray[np.float64],
        tolerance: ArrayLike,
        active: NDArray[np.bool_] | None = None,
        most: int = 30,
    ) -> Outcome: ...
