"""Cost, gradient and blocks of a problem, with the GIL taken only for what has no kernel."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.runtime.group_kernel import GroupKernel
from arael.runtime.instances import Instances
from arael.runtime.interpreter import GroupInterpreter
from arael.runtime.layout import Layout
from arael.runtime.machine import Program
from arael.runtime.natives import NativeTable
from arael.runtime.structure import Structure

class Interpreters(Protocol):
    """One interpreter per group, made when it is asked for."""

    def __getitem__(self, g: int) -> GroupInterpreter: ...

class Evaluation:
    """What the Levenberg-Marquardt loop asks of a problem."""

    single: bool
    size: int
    value_count: int
    trash: int
    shares: int
    threads: int
    states: list[list[NDArray[Any]]]
    current: int
    interpreters: Interpreters
    guarded: bool
    natives: NativeTable

    def __init__(
        self,
        layout: Layout,
        structure: Structure,
        instances: Sequence[Instances],
        stored: Sequence[NDArray[Any]],
        held_values: NDArray[np.int64],
        diagonal_at: NDArray[np.int64],
        kernels: Any,
        natives: NativeTable,
        programs: Sequence[Program | GroupKernel | None] | None = None,
    ) -> None: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def state_arrays(self) -> list[NDArray[Any]]: ...
    def replace(self, g: int, one: Instances) -> None: ...
    def start_at(self, e: int, stored: NDArray[Any]) -> None: ...
    def group_cost(self, g: int) -> float: ...
    def total_cost(self) -> float: ...
    def linearised(self) -> tuple[float, NDArray[Any], NDArray[Any]]: ...
    def group_rows(self, g: int) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def acting(self, g: int) -> NDArray[np.bool_]: ...
    def moved_by(self, step: NDArray[Any]) -> None: ...
    def raise_failure(self) -> None: ...
