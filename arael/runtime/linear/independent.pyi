from collections.abc import Sequence

from numpy import bool_, int64
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern

def independent_set(pattern: BlockPattern) -> NDArray[bool_]: ...
def named_set(pattern: BlockPattern, blocks: Sequence[int] | NDArray[int64]) -> NDArray[bool_]: ...
