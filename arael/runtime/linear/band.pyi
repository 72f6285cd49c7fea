from arael.runtime.linear.base import LinearSolver
from arael.runtime.linear.pattern import BlockPattern

class BandSolver(LinearSolver):
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool = False,
        half_bandwidth: int | None = None,
        block_half_bandwidth: int | None = None,
    ) -> None: ...
