from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import Totals
from arael.runtime.assembly.components import Partition
from arael.runtime.assembly.placement import Placement
from arael.runtime.assembly.shares import Shares
from arael.runtime.assembly.structure import Structure
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.evaluation.hooks import Hooks
from arael.runtime.evaluation.instances import Instances
from arael.runtime.layout import Entity, Group, Layout
from arael.runtime.machine.compiled import NativeTable, Program
from arael.runtime.parallel.compiled import Kept
from arael.runtime.system import System

class CompiledGroups:
    """Kernels and programs of all groups, as far as they have one."""

    widths: list[int]
    free: list[bool]

    def __init__(
        self,
        layout: Layout,
        placements: Sequence[Placement],
        kernels: Any,
        programs: Sequence[Program | GroupKernel | None],
    ) -> None: ...

class Raised(Kept):
    """The first exception of a native function in Python."""

    natives: NativeTable

    def __init__(self, natives: NativeTable) -> None: ...

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

class GroupLanes:
    """The lanes of all groups."""

    data: list[tuple[NDArray[Any], NDArray[Any]]]

    def __init__(
        self,
        groups: Sequence[Group],
        instances: Sequence[Instances],
        plan: Shares,
        widths: Sequence[int],
        states: StatePair,
        natives: NativeTable,
    ) -> None: ...
    def replace(self, g: int, one: Instances) -> None: ...

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

class ComponentLanes:
    """The instances of a problem by component."""

    components: int
    costs: list[NDArray[np.float64]]

    def keep(self, active: NDArray[np.bool_]) -> None: ...
    def evaluated(self) -> list[int]: ...

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
