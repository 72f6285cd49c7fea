from typing import Any

from numpy.typing import NDArray

class Stacks:
    bundles: int
    sequence: NDArray[Any]
    ends: NDArray[Any]
    update: NDArray[Any]
    shared: NDArray[Any]
    room: int
    shared_room: int

def place_updates(
    parents: NDArray[Any], sizes: NDArray[Any], bundle: NDArray[Any], bundles: int, pad: int
) -> Stacks: ...
