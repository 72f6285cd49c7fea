"""Bounds of parameters as hard limits of a solve."""

import numpy as np
from numpy.typing import NDArray

from arael.runtime.evaluation import Evaluation
from arael.runtime.structure import Structure

class Box:
    """The bounded scalars of a system."""

    count: int

    def __init__(
        self, evaluation: Evaluation, structure: Structure, diagonal_at: NDArray[np.int64]
    ) -> None: ...
