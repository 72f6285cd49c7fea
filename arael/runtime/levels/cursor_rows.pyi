from numpy.typing import ArrayLike

from arael.runtime.levels.rows import Rows

class CursorRows(Rows):
    def __init__(self, n: int, at: ArrayLike, target: ArrayLike) -> None: ...
    def aim(self, at: ArrayLike, target: ArrayLike) -> bool: ...
