"""The groups of a problem with all they read and add to, each evaluated by whatever can run it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.structure import Structure
from arael.runtime.assembly.totals import Totals
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.evaluation.hooks import Hooks
from arael.runtime.evaluation.instances import Instances
from arael.runtime.evaluation.natives import NativeTable
from arael.runtime.evaluation.raised import Raised
from arael.runtime.evaluation.state_pair import StatePair
from arael.runtime.layout import Layout
from arael.runtime.machine.program import Program
from arael.runtime.system import System

class Groups:
    """One group at a time, at states that move."""

    single: bool
    size: int
    value_count: int
    shares: int
    states: StatePair
    totals: Totals
    raised: Raised
    hooks: Hooks | None
    hooked: bool

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
        hooks: Hooks | None = None,
    ) -> None: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def state_arrays(self) -> list[NDArray[Any]]: ...
    def replace(self, g: int, one: Instances) -> None: ...
    def place(
        self,
        structure: Structure,
        instances: Sequence[Instances],
        held_values: NDArray[np.int64],
        diagonal_at: NDArray[np.int64],
    ) -> None: ...
    def hold(self, system: System, held_values: NDArray[np.int64]) -> None: ...
    def start_at(self, e: int, stored: NDArray[Any]) -> None: ...
    def moved_by(self, step: NDArray[Any]) -> None: ...
    def workspace(self) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def raise_failure(self) -> None: ...
