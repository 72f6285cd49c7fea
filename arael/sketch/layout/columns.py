"""Columns of the unknowns: where the numbers of entities and hidden unknowns are in `x`."""

from __future__ import annotations


class Columns:
    """Blocks of columns, taken and given back.

    Attributes
    ----------
    count : columns there are, free ones included
    """

    def __init__(self) -> None:
        self.count = 0
        self._free: dict[int, list[int]] = {}

    def take(self, size: int) -> int:
        """First column of a block of contiguous columns."""
        free = self._free.get(size)
        if free:
            return free.pop()
        at = self.count
        self.count += size
        return at

    def release(self, at: int, size: int) -> None:
        """Give a block back."""
        self._free.setdefault(size, []).append(at)
