from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.base import LinearSolver
from arael.runtime.linear.reduction import Products, Reduction

class SchurSolver(LinearSolver):
    inner: LinearSolver
    @property
    def reduction(self) -> Reduction: ...
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool,
        reduction: Reduction,
        products: Products,
        inner: LinearSolver,
    ) -> None: ...
