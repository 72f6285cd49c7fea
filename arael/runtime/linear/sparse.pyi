from typing import Any

from numpy import int64
from numpy.typing import ArrayLike, NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import Analysis
from arael.runtime.linear.base import LinearSolver

class SparseSolver(LinearSolver):
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool = False,
        ordering: str = "auto",
        analysis: Analysis | None = None,
    ) -> None: ...
    def factor_forward(self, values: ArrayLike, diagonal: ArrayLike, b: ArrayLike) -> int: ...
    def forward(self, b: ArrayLike) -> None: ...
    def backward(self) -> NDArray[Any]: ...
    def parts(
        self,
    ) -> tuple[NDArray[int64], NDArray[Any], NDArray[Any], NDArray[Any], NDArray[int64]]: ...
