from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.runtime.linear.pattern import BlockPattern

class LinearSolver:
    single: bool
    pattern: BlockPattern
    plan: dict[str, Any]
    n: int
    def __init__(self, pattern: BlockPattern, single: bool = False) -> None: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    def report(self) -> dict[str, Any]: ...
    def factorise(self, values: ArrayLike, diagonal: ArrayLike) -> int: ...
    def solved(self, b: ArrayLike) -> NDArray[np.floating[Any]]: ...
