"""Bounds of parameters as hard limits of a solve."""

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.structure import Structure
from arael.runtime.evaluation.evaluation import Evaluation
from arael.runtime.system import System

class Box:
    """The bounded scalars of a system."""

    count: int

    def __init__(
        self, evaluation: Evaluation, structure: Structure, diagonal_at: NDArray[np.int64]
    ) -> None: ...
    def restrict(
        self, component: NDArray[np.int32] | None = None, kept: NDArray[np.bool_] | None = None
    ) -> None: ...

def stored_places(
    system: System, scalars: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]: ...
