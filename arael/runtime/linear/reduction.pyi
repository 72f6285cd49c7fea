from typing import Any

from numpy import bool_, int64
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern

Ints = NDArray[int64]

PADDING: int

class Reduction:
    pattern: BlockPattern
    eliminated: NDArray[bool_]
    kept: Ints
    entities: NDArray[Any]
    couplings: NDArray[Any]
    entity_of: Ints
    scalars: Ints
    padded: Ints
    padded_size: int
    factor_size: int
    stored_size: int
    @property
    def sizes(self) -> Ints: ...

class Products:
    pattern: BlockPattern
    sources: Ints
    tasks: Ints
    pairs: NDArray[Any]

def reduce(pattern: BlockPattern, eliminated: NDArray[bool_]) -> Reduction: ...
def kept_blocks(r: Reduction) -> Products: ...
def products(r: Reduction, group: Ints | None = None, reach: int | None = None) -> Products: ...
