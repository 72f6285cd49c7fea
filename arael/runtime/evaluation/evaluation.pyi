"""Cost, gradient and blocks of a whole problem, shared among threads."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.components import Partition
from arael.runtime.evaluation.component_lanes import ComponentLanes
from arael.runtime.evaluation.groups import Groups

class Evaluation(Groups):
    """What the Levenberg-Marquardt loop asks of a problem; parameters as those of `Groups`."""

    threads: int
    guarded: bool
    updating: bool

    def total_cost(self) -> float: ...
    def component_lanes(self, partition: Partition) -> ComponentLanes: ...
    def component_costs(self, chosen: ComponentLanes) -> NDArray[np.float64]: ...
    def linearised(
        self,
        workspace: tuple[NDArray[Any], NDArray[Any]] | None = None,
        chosen: ComponentLanes | None = None,
    ) -> tuple[float, NDArray[Any], NDArray[Any]]: ...
    def group_cost(self, g: int) -> float: ...
    def group_linearised(self, g: int, gradient: NDArray[Any], values: NDArray[Any]) -> float: ...
    def group_rows(self, g: int) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def acting(self, g: int) -> NDArray[np.bool_]: ...
