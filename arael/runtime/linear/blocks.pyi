from typing import Any

from numpy.typing import ArrayLike, NDArray

from arael.runtime.assembly.pattern import BlockPattern

def table_of(
    first: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    place: ArrayLike,
    leading: ArrayLike,
    how: ArrayLike,
) -> NDArray[Any]: ...
def block_table(pattern: BlockPattern, leading: int) -> NDArray[Any]: ...
