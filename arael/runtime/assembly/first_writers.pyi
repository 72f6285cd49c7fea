from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

def find_firsts(
    block_at: list[NDArray[np.int64]],
    turns: list[NDArray[np.uint8]],
    counts: Sequence[int],
    areas: list[list[int]],
    order: Sequence[int],
    may: Sequence[bool],
    nowhere: Any,
    extent: int,
    near: int,
) -> tuple[list[NDArray[np.uint8]], NDArray[np.int64]]: ...
