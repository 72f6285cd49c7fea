from numpy import int64
from numpy.typing import NDArray

Ints = NDArray[int64]

def elimination_tree(start: Ints, neighbours: Ints, order: Ints) -> Ints: ...
def postorder(parents: Ints) -> Ints: ...
def column_counts(
    start: Ints, neighbours: Ints, order: Ints, parents: Ints, weights: Ints
) -> tuple[Ints, Ints]: ...
