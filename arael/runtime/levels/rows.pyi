from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

class Rows:
    n: int
    m: int
    pattern_version: int
    @property
    def indptr(self) -> NDArray[np.int32]: ...
    @property
    def indices(self) -> NDArray[np.int32]: ...
    def evaluate(self, x: ArrayLike) -> NDArray[np.float64]: ...
    def holds(self, x: ArrayLike, tolerance: ArrayLike) -> bool: ...
    def worst(self, x: ArrayLike, tolerance: ArrayLike) -> tuple[int, float, float]: ...
    def jacobian(self, x: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def check(self, code: int) -> None: ...

class PythonRows(Rows):
    def __init__(
        self,
        function: Callable[[NDArray[np.float64]], ArrayLike],
        jacobian: Callable[[NDArray[np.float64]], ArrayLike] | None = None,
        *,
        n: int,
        m: int,
        pattern: Sequence[Sequence[int]] | NDArray[np.bool_] | None = None,
    ) -> None: ...
    def set_pattern(
        self, pattern: Sequence[Sequence[int]] | NDArray[np.bool_] | None = None
    ) -> None: ...
