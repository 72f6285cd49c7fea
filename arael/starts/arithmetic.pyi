from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.linear.pattern import BlockPattern

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

def information_of(factor: Array) -> tuple[Array, bool]: ...
def planar(angle: Array) -> Array: ...
def angles(rotation: Array) -> Array: ...
def matrices(quaternion: Array) -> Array: ...
def quaternions(rotation: Array) -> Array: ...
def rotation_blocks(step: Array, weight: Array) -> tuple[Array, Array, Array]: ...
def position_blocks(
    measured: Array,
    position: Array,
    information: Array,
    rotation: Array,
    from_rows: Ints,
    to_rows: Ints,
) -> tuple[Array, Array]: ...
def add_rows(target: Array, rows: Ints, values: Array, sign: float) -> None: ...
def projected(relaxed: Array) -> tuple[Array, Bools]: ...
def places_of(pattern: BlockPattern, block_of: Ints, from_rows: Ints, to_rows: Ints) -> Ints: ...
def assembled(
    pattern: BlockPattern,
    block_of: Ints,
    places: Ints,
    from_rows: Ints,
    to_rows: Ints,
    blocks: tuple[Any, Any, Any],
    own: Array,
    right: Array,
    held: Bools,
    at: Array,
) -> tuple[Array, Array, Array, bool]: ...
