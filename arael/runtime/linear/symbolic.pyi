from typing import Any

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]

def adjacency(pattern: Any) -> tuple[Ints, Ints]: ...
def reach_of(pattern: Any) -> int: ...
def place_blocks(pattern: Any, supernodes: Any, fronts: Any, pad: int) -> tuple[Ints, Ints]: ...
