from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.runtime.levels.structure import Structure

class RowFactor:
    n: int
    m: int
    count: int
    components: int
    pivot_tolerance: float
    @property
    def structure(self) -> Structure: ...
    def __init__(
        self, n: int, m: int, structure: Structure, scales: ArrayLike, basic: Any, tolerance: float
    ) -> None: ...
    def dropped(self) -> NDArray[np.int32]: ...
