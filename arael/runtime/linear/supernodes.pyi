from numpy import int64
from numpy.typing import NDArray

Ints = NDArray[int64]

class Supernodes:
    order: Ints
    start: Ints
    parent: Ints
    row_start: Ints
    rows: Ints

def find_supernodes(start: Ints, neighbours: Ints, weights: Ints, order: Ints) -> Supernodes: ...
def price_of(nodes: Supernodes, sizes: Ints) -> tuple[int, float, float, float]: ...
