from typing import Any

from numpy import int64
from numpy.typing import NDArray

from arael.runtime.linear.stacks import Stacks
from arael.runtime.linear.supernodes import Supernodes

Ints = NDArray[int64]

class Fronts:
    columns: Ints
    below: Ints
    first: Ints
    tall: Ints
    low: Ints
    triangle: Ints
    panel: Ints
    alone: Stacks
    together: Stacks
    child_start: Ints
    children: Ints
    run_start: Ints
    run_inside: Ints
    runs: NDArray[Any]
    strip_start: Ints
    strips: NDArray[Any]
    storage: int
    bundle: Ints
    bundles: int

def plan_fronts(supernodes: Supernodes, weights: Ints, pad: int, large: int) -> Fronts: ...
