from collections.abc import Sequence
from typing import Any

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.base import LinearSolver
from arael.runtime.linear.reduction import Products, Reduction

class ConjugateSolver(LinearSolver):
    solves: int
    steps: int
    forcing: float
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool,
        reduction: Reduction,
        blocks: Products,
        formed: bool,
        parts: Sequence[tuple[Products, LinearSolver]],
        *,
        tolerance: float = 0.1,
        floor: float = 1e-6,
        iterations: int = 500,
    ) -> None: ...
    def restart(self) -> None: ...
    def report(self) -> dict[str, Any]: ...
