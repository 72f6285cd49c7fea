from numpy import int64
from numpy.typing import NDArray

Ints = NDArray[int64]

def minimum_degree(start: Ints, neighbours: Ints, weights: Ints, staying: int = 0) -> Ints: ...
