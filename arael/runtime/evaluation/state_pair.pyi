"""The states of all entities twice over: as accepted, and as a step would have them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.evaluation.raised import Raised
from arael.runtime.layout import Entity
from arael.runtime.system import System

class StatePair:
    """What the parameters are and what they are tried to be."""

    single: bool
    current: int
    arrays: list[list[NDArray[Any]]]

    def __init__(
        self,
        entities: Sequence[Entity],
        system: System,
        stored: Sequence[NDArray[Any]],
        single: bool,
        kernels: Any,
        raised: Raised,
    ) -> None: ...
    def hold(self, system: System) -> None: ...
    def start_at(self, e: int, stored: NDArray[Any]) -> None: ...
    def restrict(
        self, component: NDArray[np.int32] | None = None, kept: NDArray[np.bool_] | None = None
    ) -> None: ...

def rows_of(kept: NDArray[np.bool_], gap: int) -> NDArray[np.int64]: ...
