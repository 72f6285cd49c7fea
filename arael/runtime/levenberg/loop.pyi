"""The loop of a solve: a trust region with the dogleg, or Levenberg-Marquardt."""

from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from arael.config import LmConfig
from arael.runtime.assembly.components import Partition
from arael.runtime.evaluation.component_lanes import ComponentLanes
from arael.runtime.evaluation.evaluation import Evaluation
from arael.runtime.levenberg.box import Box
from arael.runtime.levenberg.dogleg import Dogleg
from arael.runtime.levenberg.inner import InnerSteps
from arael.runtime.levenberg.settings import STATUSES as STATUSES
from arael.runtime.levenberg.vectors import Vectors
from arael.runtime.linear.base import LinearSolver

class Minimiser:
    """One solve."""

    evaluation: Evaluation
    solver: LinearSolver
    start_cost: float
    current_cost: float
    attempts: int
    accepted: int
    factorisations: int
    factor_seconds: float
    narrowings: int
    damping: float
    vectors: Vectors
    lanes: ComponentLanes | None
    dogleg: Dogleg
    inner: InnerSteps | None
    predicted_decrease: float
    gradient_norm: float
    noise_floor: float

    def __init__(
        self,
        evaluation: Evaluation,
        solver: LinearSolver,
        box: Box,
        config: LmConfig,
        watcher: Any,
        watched: bool,
        partition: Partition | None = None,
        separable: Callable[[], InnerSteps | None] | None = None,
    ) -> None: ...
    def run(self) -> str: ...
    @property
    def history(self) -> NDArray[Any]: ...
    @property
    def components(self) -> NDArray[Any]: ...
    @property
    def timing(self) -> dict[str, float]: ...
