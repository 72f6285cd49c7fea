from collections.abc import Sequence

from numpy.typing import ArrayLike

from arael.runtime.machine.tape import Tape

class RowExpression:
    row: int
    quantities: tuple[int, ...]
    unknowns: tuple[int, ...]
    def __init__(
        self,
        row: int,
        tape: Tape,
        quantities: Sequence[int],
        unknowns: Sequence[int],
        numbers: Sequence[float],
        contributions: int,
    ) -> None: ...
    def set_numbers(self, numbers: ArrayLike) -> None: ...
