from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Layout

class LaneTable:
    struct: str
    refs: tuple[str, ...]
    widths: tuple[int, ...]
    fields: tuple[str, ...]
    residuals: int
    count: int
    active: int
    defaults: NDArray[np.float64]
    def __init__(self, layout: Layout, number: int, kernels: Any) -> None: ...
