from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.base import LinearSolver

class LapackBandSolver(LinearSolver):
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool = False,
        half_bandwidth: int | None = None,
        block_half_bandwidth: int | None = None,
    ) -> None: ...
