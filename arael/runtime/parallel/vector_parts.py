"""In how many parts threads pass over the scalars of a vector, so that sums have the same bits."""

from __future__ import annotations

#: Most parts of a vector.
MOST_PARTS = 16

#: Fewest scalars of a part; a vector of less than four of these is one part.
GRAIN = 8192


def count_parts(n: int) -> int:
    """Number of parts of `n` scalars: by their number alone, never by that of the threads."""
    return min(MOST_PARTS, n // GRAIN) if n >= 4 * GRAIN else 1
