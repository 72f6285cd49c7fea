"""A solver for some of the independent parts of a system, in the place of one for the whole."""

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.base import LinearSolver

class RemainingSolver(LinearSolver):
    """Solves for the scalars that remain; of solutions, the others stay as they are."""

    inner: LinearSolver
    def __init__(
        self,
        pattern: BlockPattern,
        inner: LinearSolver,
        scalars: NDArray[np.int64],
        values: NDArray[np.int64],
    ) -> None: ...
