from numpy import int8, int64
from numpy.typing import NDArray

Ints = NDArray[int64]

def find_separator(start: Ints, neighbours: Ints, weights: Ints) -> NDArray[int8]: ...
