"""The vectors of one solve, and what the Levenberg-Marquardt loop does with them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.totals import Totals

class Vectors:
    """Gradient, diagonal and step of a system."""

    single: bool
    n: int
    threads: int
    gradient_array: NDArray[Any]
    value_array: NDArray[Any]
    diagonal_array: NDArray[Any]
    damped_array: NDArray[Any]
    step_array: NDArray[Any]

    components: int

    def __init__(
        self,
        n: int,
        totals: Totals,
        threads: int,
        component: NDArray[np.int32] | None = None,
        components: int = 1,
    ) -> None: ...
    def sound(self) -> bool: ...

def runs_of(
    n: int, component: NDArray[np.int32] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]: ...
