"""The vectors of one solve, and what the Levenberg-Marquardt loop does with them."""

from typing import Any

from numpy.typing import NDArray

from arael.runtime.totals import Totals

GRAIN: int

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

    def __init__(self, n: int, totals: Totals, threads: int) -> None: ...

def count_parts(n: int) -> int: ...
