from collections.abc import Sequence
from typing import Any

from numpy import bool_, int8, int64
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.compiled import Interruption

def time_of_front(columns: Any, rows: Any) -> Any: ...

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
def give_back() -> None: ...
def adjacency(pattern: Any) -> tuple[Ints, Ints]: ...
def reach_of(pattern: Any) -> int: ...
def place_blocks(pattern: Any, supernodes: Any, fronts: Any, pad: int) -> tuple[Ints, Ints]: ...
def independent_set(pattern: BlockPattern) -> NDArray[bool_]: ...
def named_set(pattern: BlockPattern, blocks: Sequence[int] | NDArray[int64]) -> NDArray[bool_]: ...
def minimum_degree(
    start: Ints,
    neighbours: Ints,
    weights: Ints,
    staying: int = 0,
    interruption: Interruption | None = None,
) -> Ints: ...
def find_separator(start: Ints, neighbours: Ints, weights: Ints) -> NDArray[int8]: ...
def join_siblings(
    start: Ints, parent: Ints, row_start: Ints, rows: Ints, weights: Ints
) -> Ints: ...
def elimination_tree(start: Ints, neighbours: Ints, order: Ints) -> Ints: ...
def postorder(parents: Ints) -> Ints: ...
def column_counts(
    start: Ints, neighbours: Ints, order: Ints, parents: Ints, weights: Ints
) -> tuple[Ints, Ints]: ...

class Supernodes:
    order: Ints
    start: Ints
    parent: Ints
    row_start: Ints
    rows: Ints

def find_supernodes(start: Ints, neighbours: Ints, weights: Ints, order: Ints) -> Supernodes: ...
def price_of(nodes: Supernodes, sizes: Ints) -> tuple[int, float, float, float]: ...
