import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.runtime.compiled import Interruption
from arael.runtime.orthogonal.results import Dependency, Vectors

Doubles = NDArray[np.float64]
Ints = NDArray[np.int32]

class RankQR:
    m: int
    n: int
    tolerance: float
    factored: bool
    interruption: Interruption
    def __init__(
        self,
        m: int,
        n: int,
        indptr: ArrayLike,
        indices: ArrayLike,
        priority: ArrayLike | None = None,
        tolerance: float | None = None,
        interruption: Interruption | None = None,
    ) -> None: ...
    def factor(
        self,
        entries: ArrayLike,
        scale: ArrayLike | None = None,
        shortest: float = 0.0,
    ) -> None: ...
    @property
    def rank(self) -> int: ...
    @property
    def nullity(self) -> int: ...
    @property
    def smallest_kept(self) -> float: ...
    @property
    def largest_dropped(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def gap(self) -> float: ...
    @property
    def scales(self) -> tuple[Doubles, Doubles]: ...
    @property
    def dependent(self) -> Ints: ...
    @property
    def independent(self) -> NDArray[np.bool_]: ...
    def dependency(self, equation: int) -> Dependency: ...
    def dependency_of(self, unknowns: ArrayLike, values: ArrayLike) -> Dependency: ...
    def least_norm(self, right: ArrayLike) -> Doubles: ...
    def null_vectors(self) -> Vectors: ...
