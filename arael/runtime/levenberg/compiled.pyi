from collections.abc import Callable
from typing import Any

import numpy as np
from numpy import float64
from numpy.typing import NDArray

from arael.config import LmConfig
from arael.runtime.assembly.compiled import Totals
from arael.runtime.assembly.components import Partition
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.structure import Structure
from arael.runtime.evaluation.compiled import ComponentLanes, Evaluation
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.system import System

STATUSES: tuple[str, ...]

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

class Vectors:
    """Gradient, diagonal and step of a system."""

    single: bool
    n: int
    threads: int
    gradient_array: NDArray[Any]
    value_array: NDArray[Any]
    diagonal_array: NDArray[Any]
    scale_array: NDArray[Any]
    damped_array: NDArray[Any]
    step_array: NDArray[Any]

    components: int

    def __init__(
        self,
        n: int,
        totals: Totals,
        threads: int,
        component: NDArray[np.int32] | None = None,
        components: int = 1,
    ) -> None: ...
    def sound(self) -> bool: ...

def runs_of(
    n: int, component: NDArray[np.int32] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]: ...

class Dogleg:
    """Trust regions whose steps lie on Powell's dogleg."""

    floor: float

    @property
    def radius(self) -> float: ...

class InnerSteps:
    count: int
    def __init__(
        self, evaluation: Evaluation, entities: Any, partition: Any, floor: float
    ) -> None: ...

RECORD: np.dtype[Any]

class History:
    """Records of attempts, as many as there is place for."""

    count: int

    def __init__(self, capacity: int) -> None: ...
    def grow(self, capacity: int) -> None: ...
    def double(self) -> None: ...
    def array(self) -> NDArray[Any]: ...

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

Floats = NDArray[float64]

class RemoteEvaluation(Evaluation):
    parts: Any
    def is_guarded(self, guarded: bool) -> None: ...

class RemoteBox(Box):
    parts: Any

class RemoteSolver(LinearSolver):
    parts: Any
    def __init__(self, pattern: BlockPattern, parts: Any) -> None: ...

def curvature_of(
    box: Box, values: Floats, step: Floats, partition: Partition | None = None
) -> Floats: ...
