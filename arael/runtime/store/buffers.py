"""Growing arrays of equal length: the memory of a table.

Rows live in a window ``start : start + size`` of every array, so that a deque can remove rows at
its front without moving others. A view is valid until rows are added or removed.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Buffers:
    """Named columns of equal length, each contiguous."""

    def __init__(self) -> None:
        self.start = 0
        self.size = 0
        self._capacity = 0
        self._arrays: dict[str, Array] = {}
        # Views of the present window by name: a solve looks at each column several times.
        self._views: dict[str, Array] = {}
        self._several: dict[tuple[str, ...], list[Array]] = {}

    def add(self, name: str, dtype: Any, shape: tuple[int, ...] = ()) -> None:
        """Declare a column; to be called before rows are added."""
        self._arrays[name] = np.empty((self._capacity, *shape), dtype)
        self._views.pop(name, None)
        self._several.clear()

    def __len__(self) -> int:
        """Number of columns."""
        return len(self._arrays)

    def __contains__(self, name: str) -> bool:
        return name in self._arrays

    @property
    def names(self) -> list[str]:
        """Names of all columns."""
        return list(self._arrays)

    @property
    def row_bytes(self) -> int:
        """Bytes per row."""
        return sum(a.itemsize * prod(a.shape[1:]) for a in self._arrays.values())

    def view(self, name: str) -> Array:
        """Live view (size, *shape) of a column."""
        found = self._views.get(name)
        if found is None:
            found = self._views[name] = self._arrays[name][self.start : self.start + self.size]
        return found

    def put(self, at: int, row: Mapping[str, Any]) -> None:
        """Write values into the row at `at`, counted from the beginning of the memory."""
        for name, value in row.items():
            self._arrays[name][at] = value

    def _moved(self) -> None:
        """Forget the views: the window or the memory is another one."""
        self._views.clear()
        self._several.clear()

    def views(self, names: tuple[str, ...]) -> list[Array]:
        """Live views of several columns."""
        found = self._several.get(names)
        if found is None:
            found = self._several[names] = [self.view(name) for name in names]
        return found

    def grow_back(self, count: int) -> bool:
        """Add `count` rows of undefined content at the back; True if the rows moved."""
        moved = self._make_room(0, count)
        self.size += count
        self._moved()
        return moved

    def grow_front(self, count: int) -> bool:
        """Add `count` rows of undefined content at the front; True if the rows moved."""
        moved = self._make_room(count, 0)
        self.start -= count
        self.size += count
        self._moved()
        return moved

    def _make_room(self, front: int, back: int) -> bool:
        """Reallocate if the capacity is exceeded; it doubles, so that appends are amortised."""
        if self.start >= front and self.start + self.size + back <= self._capacity:
            return False
        needed = front + self.size + back
        capacity = max(2 * needed, 8)
        # Free capacity on the growing side; a window that only shifted is moved back.
        start = capacity - self.size - (capacity - needed) // 2 if front else 0
        for name, old in self._arrays.items():
            fresh = np.empty((capacity, *old.shape[1:]), old.dtype)
            fresh[start : start + self.size] = old[self.start : self.start + self.size]
            self._arrays[name] = fresh
        moved = self.size > 0
        self._capacity, self.start = capacity, start
        return moved

    def drop_front(self, count: int) -> None:
        """Remove the first `count` rows; no other row moves."""
        self._forget(slice(self.start, self.start + count))
        self.start += count
        self.size -= count
        self._moved()

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Keep the rows of `mask`, in their order."""
        left = int(mask.sum())
        for name, array in self._arrays.items():
            array[self.start : self.start + left] = self.view(name)[mask]
        self._forget(slice(self.start + left, self.start + self.size))
        self.size = left
        self._moved()

    def _forget(self, rows: slice) -> None:
        """Release objects (strings) of rows outside the window."""
        for array in self._arrays.values():
            if array.dtype == object:
                array[rows] = None
