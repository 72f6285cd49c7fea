from numpy import int64
from numpy.typing import NDArray

from arael.runtime.interruption import Interruption

Ints = NDArray[int64]

def minimum_degree(
    start: Ints,
    neighbours: Ints,
    weights: Ints,
    staying: int = 0,
    interruption: Interruption | None = None,
) -> Ints: ...
