"""Stable handles for rows that move.

A handle packs a slot and its generation into one int64. A slot belongs to one row while others are
added and removed; when the row is removed the slot's generation increases, so that old handles are
detected as stale.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.store.compiled import rows_of_handles

Ints = NDArray[np.int64]

NULL = -1
GENERATION_SHIFT = 32
SLOT_MASK = (1 << GENERATION_SHIFT) - 1
LAST_GENERATION = (1 << 30) - 1
GONE = -1


class Slots:
    """Slot map of one table: the position of each slot's row, and its generation."""

    def __init__(self, first_generation: int = 0) -> None:
        self._first_generation = first_generation
        self._positions: Ints = np.empty(0, np.int64)
        self._generations: Ints = np.empty(0, np.int64)
        self._used = 0
        self._free: list[int] = []

    @property
    def next_generation(self) -> int:
        """A generation that no handle of this map has."""
        used = self._generations[: self._used]
        return int(used.max(initial=self._first_generation)) + 1

    def take(self, count: int) -> Ints:
        """`count` slots for new rows, freed ones first; `move` sets their positions."""
        reused = min(count, len(self._free))
        fresh = count - reused
        slots = np.empty(count, np.int64)
        if reused:
            slots[:reused] = self._free[-reused:]
            del self._free[-reused:]
        if fresh:
            self._grow(self._used + fresh)
            slots[reused:] = np.arange(self._used, self._used + fresh)
            self._used += fresh
        return slots

    def take_one(self, position: int) -> tuple[int, int]:
        """A slot for a new row at `position`, and its handle."""
        if self._free:
            slot = self._free.pop()
        else:
            slot = self._used
            self._grow(slot + 1)
            self._used += 1
        self._positions[slot] = position
        return slot, self.handle(slot)

    def _grow(self, needed: int) -> None:
        capacity = len(self._positions)
        if needed <= capacity:
            return
        capacity = max(needed, 2 * capacity, 8)
        positions = np.full(capacity, GONE, np.int64)
        generations = np.full(capacity, self._first_generation, np.int64)
        positions[: self._used] = self._positions[: self._used]
        generations[: self._used] = self._generations[: self._used]
        self._positions, self._generations = positions, generations

    def release(self, slots: Ints) -> None:
        """Free slots; every handle to them becomes stale."""
        self._positions[slots] = GONE
        self._generations[slots] += 1
        worn_out = self._generations[slots] >= LAST_GENERATION
        self._free.extend(slots[~worn_out][::-1].tolist())

    def move(self, slots: Ints, positions: Ints | int) -> None:
        """Set the positions of the rows of these slots."""
        self._positions[slots] = positions

    def handles(self, slots: Ints) -> Ints:
        """Return handles of live slots."""
        return (self._generations[slots] << GENERATION_SHIFT) | slots

    def handle(self, slot: int) -> int:
        """Return the handle of one live slot."""
        generation: int = self._generations.item(slot)
        return (generation << GENERATION_SHIFT) | slot

    def positions_of_slots(self, slots: Ints) -> Ints:
        """Positions of slots known to be live."""
        return self._positions[slots]

    def position(self, handle: int) -> int:
        """Position of one handle's row; `GONE` if stale."""
        slot = handle & SLOT_MASK
        if handle < 0 or slot >= self._used:
            return GONE
        if self._generations.item(slot) != handle >> GENERATION_SHIFT:
            return GONE
        found: int = self._positions.item(slot)
        return found

    def positions(self, handles: NDArray[Any]) -> Ints:
        """Positions of the rows of `handles`; `GONE` for null and stale ones."""
        return self.rows(handles, 0)

    def rows(self, handles: NDArray[Any], start: int) -> Ints:
        """Positions counted from `start`; -1 for null and stale handles."""
        flat = np.ascontiguousarray(handles, dtype=np.int64)
        tables = self._positions[: self._used], self._generations[: self._used]
        found = rows_of_handles(flat.ravel(), *tables, start, GENERATION_SHIFT)
        return found.reshape(flat.shape)
