"""Costs of instances, component by component, and which blocks of lanes are still evaluated."""

import numpy as np
from numpy.typing import NDArray

class ComponentLanes:
    """The instances of a problem by component."""

    components: int
    costs: list[NDArray[np.float64]]

    def keep(self, active: NDArray[np.bool_]) -> None: ...
    def evaluated(self) -> list[int]: ...
