"""The arrays of J'r and J'J, with what lies behind them: trash, and places of the shares' own."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.shares import Shares

class Totals:
    """What is done to the arrays before and after contributions are added to them."""

    single: bool
    gradient_extent: int
    value_extent: int

    def __init__(
        self,
        plan: Shares,
        held: NDArray[np.int64],
        held_values: NDArray[np.int64],
        diagonal_at: NDArray[np.int64],
        single: bool,
    ) -> None: ...
    def hold_others(self, held: NDArray[np.int64], held_values: NDArray[np.int64]) -> None: ...
    def restrict(
        self, gradient: NDArray[np.int64] | None = None, values: NDArray[np.int64] | None = None
    ) -> None: ...
    def take_arrays(self, other: Totals) -> None: ...
    def kept(self) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def zeros(self) -> tuple[NDArray[Any], NDArray[Any]]: ...
