from typing import Any

from numpy.typing import NDArray

class Stacks:
    bundles: int
    sequence: NDArray[Any]
    ends: NDArray[Any]
    update: NDArray[Any]
    shared: NDArray[Any]
    extent: int
    shared_extent: int

def place_updates(
    parents: NDArray[Any], sizes: NDArray[Any], bundle: NDArray[Any], bundles: int, pad: int
) -> Stacks: ...
