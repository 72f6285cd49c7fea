"""Splits the passes of a block elimination into parts for parallel execution.

The parts follow from the problem and not from the number of threads, so that sums over parts are
bit-identical for any number.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from arael.runtime.linear.compiled import Products, Reduction

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

#: Maximum parts of a pass, and minimum predicted nanoseconds of a part.
PARTS = 16
GRAIN = 100_000.0

# A pass of fewer grains is not split.
_SHORT = 10

#: Maximum parts of a sweep.
SWEEPS = 8

# Maximum size of the vectors of all parts of a sweep, as a fraction of the data swept.
_ROOM = 0.25


def count(nanoseconds: float) -> int:
    """Number of parts of a pass of the given duration."""
    # Waking a helper may take as long as a short pass, and longer on a loaded machine.
    return int(min(PARTS, nanoseconds // GRAIN)) if nanoseconds >= _SHORT * GRAIN else 1


def sweeps(reduction: Reduction, nanoseconds: float) -> int:
    """Number of parts of a sweep, each with a padded vector."""
    fit = 1 + int(_ROOM * reduction.stored_size) // max(1, reduction.padded_size)
    return min(SWEEPS, fit, count(nanoseconds / 2))


def entity_costs(reduction: Reduction) -> Floats:
    """(ne,) predicted nanoseconds to eliminate each entity."""
    d = reduction.entities["size"][:-1].astype(np.float64)
    ends = reduction.entities["couplings"]
    width = reduction.couplings["width"].astype(np.float64)
    each = 8.0 + 0.2 * d[reduction.entity_of] ** 2 * width
    before = np.concatenate(([0.0], np.cumsum(each)))
    own: Floats = 40.0 + 2.0 * d * d + 0.2 * d**3
    own += before[ends[1:]] - before[ends[:-1]]
    return own


def split(costs: Floats, parts: int) -> Ints:
    """(parts + 1,) bounds of consecutive parts of about equal cost."""
    before = np.concatenate(([0.0], np.cumsum(costs)))
    ends = np.searchsorted(before, before[-1] * np.arange(parts + 1) / parts)
    ends[0], ends[-1] = 0, len(costs)
    found: Ints = ends.astype(np.int64)
    return found


def split_columns(products: Products) -> Ints:
    """Split the sums of a reduced system by columns.

    Returns
    -------
    (parts + 1, 3) int64
        Blocks, scalars and tasks at which parts begin and end.
    """
    pattern = products.pattern
    place, height, width, depth, _, pairs = products.tasks.astype(np.float64).T
    each = 12.0 + 0.15 * height * width + pairs * (4.0 + depth * height * width / 28.0)
    # Tasks are in the order of their blocks, and blocks in that of their columns.
    by_place = np.argsort(pattern.value_start)
    found = np.searchsorted(pattern.value_start[by_place], place)
    block = by_place[found] if len(place) else np.zeros(0, dtype=np.int64)
    first_task = np.searchsorted(block, pattern.column_start)
    before = np.concatenate(([0.0], np.cumsum(each)))
    blocks = np.diff(pattern.column_start)
    costs = np.diff(before[first_task]) + 10.0 * blocks
    columns = split(costs, count(float(costs.sum())))
    ends = (pattern.column_start[columns], pattern.offsets[columns], first_task[columns])
    return np.ascontiguousarray(np.stack(ends, axis=1), dtype=np.int64)
