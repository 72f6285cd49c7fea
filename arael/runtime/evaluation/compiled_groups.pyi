"""What runs each group without Python: a kernel, or a program of the expression machine."""

from collections.abc import Sequence
from typing import Any

from arael.runtime.assembly.placement import Placement
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.layout import Layout
from arael.runtime.machine.program import Program

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
