"""The record of an attempt, and those of all attempts of a solve."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

RECORD: np.dtype[Any]

class History:
    """Records of attempts, as many as there is place for."""

    count: int

    def __init__(self, capacity: int) -> None: ...
    def grow(self, capacity: int) -> None: ...
    def double(self) -> None: ...
    def array(self) -> NDArray[Any]: ...
