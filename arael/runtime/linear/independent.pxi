"""Choice of an independent set of entities to eliminate first."""

import numpy as np

from libc.stdint cimport int64_t, uint8_t

from arael.runtime.address cimport address, writable

from arael.diagnostics.records import AraelError, Diagnostic

# An entity with more couplings than this multiple of the average would fill the reduced system and
# is kept; entities with few couplings are always eliminated.
cdef double HUB = 10
cdef double FEW = 64


def independent_set(pattern):
    """Choose pairwise uncoupled entities to eliminate.

    Entities of one size are treated as one kind (points, landmarks). A kind without couplings
    within itself that is half of the entities is taken as a whole, except for hubs coupled with
    nearly all others. Otherwise entities are taken one by one, those with the fewest couplings
    first.

    Parameters
    ----------
    pattern : BlockPattern

    Returns
    -------
    (nb,) bool
    """
    cdef Py_ssize_t nb = pattern.block_count, v, count, most = 0
    sizes = pattern.sizes
    starts, neighbours = adjacency(pattern)
    cdef const int64_t* start = <const int64_t*>address(starts, np.int64)
    cdef const int64_t* other = <const int64_t*>address(neighbours, np.int64)
    cdef const int64_t* size = <const int64_t*>address(sizes, np.int64)
    cdef double often = max(FEW, HUB * (start[nb] / <double>max(nb, 1)))
    usable, taken = np.empty(nb, dtype=np.bool_), np.empty(nb, dtype=np.bool_)
    cdef uint8_t* can = <uint8_t*>writable(usable, np.bool_)
    cdef uint8_t* found = <uint8_t*>writable(taken, np.bool_)
    for v in range(nb):
        can[v] = size[v] > 0 and start[v + 1] - start[v] <= often
        most = max(most, size[v])
    # Sizes that half of all entities have: two at most.
    counts = np.zeros(most + 1, dtype=np.int64)
    cdef int64_t* times = <int64_t*>writable(counts, np.int64)
    cdef Py_ssize_t one
    for v in range(nb):
        times[size[v]] += 1
    for one in range(1, most + 1):
        if 2 * times[one] < nb:
            continue
        count = 0
        for v in range(nb):
            found[v] = can[v] and size[v] == one
            count += found[v]
        if 2 * count >= nb and not coupled(nb, start, other, found):
            return taken
    greedy(nb, start, other, size, can, found)
    return taken


def named_set(pattern, blocks):
    """Check a set given by the user.

    Parameters
    ----------
    pattern : BlockPattern
    blocks : sequence of int
        Block rows to eliminate.

    Returns
    -------
    (nb,) bool

    Raises
    ------
    AraelError
        E0842 for a block that does not exist, or naming two that are coupled.
    """
    chosen = np.asarray(blocks, dtype=np.int64).ravel()
    nb = pattern.block_count
    if len(chosen) and (chosen.min() < 0 or chosen.max() >= nb):
        raise AraelError(
            Diagnostic(
                "E0842",
                f"eliminate must name blocks from 0 to {nb - 1}, "
                f"found {chosen[(chosen < 0) | (chosen >= nb)][0]}",
                origin="solver options",
            )
        )
    named = np.zeros(nb, dtype=bool)
    named[chosen] = True
    low, high = _couplings(pattern)
    both = np.flatnonzero(named[low] & named[high])
    if len(both):
        offsets = pattern.offsets
        a = pattern.name_of(int(offsets[low[both[0]]]))
        b = pattern.name_of(int(offsets[high[both[0]]]))
        raise AraelError(
            Diagnostic(
                "E0842",
                f"{a} and {b} are coupled, so they cannot both be eliminated first",
                origin="solver options",
                help=(
                    "eliminate only entities that share no residual with each other",
                    "or leave the choice to the solver: eliminate='auto'",
                ),
            )
        )
    return named & (np.asarray(pattern.sizes) > 0)


def _couplings(pattern):
    """Off-diagonal blocks as pairs of block rows, the lower number first."""
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    off = pattern.rows != columns
    return columns[off], pattern.rows[off]


cdef bint coupled(
    Py_ssize_t nb, const int64_t* start, const int64_t* other, const uint8_t* inside
) noexcept nogil:
    """Whether two of the chosen entities are coupled."""
    cdef Py_ssize_t v, k
    for v in range(nb):
        if inside[v]:
            for k in range(start[v], start[v + 1]):
                if inside[other[k]]:
                    return True
    return False


cdef greedy(
    Py_ssize_t nb,
    const int64_t* start,
    const int64_t* other,
    const int64_t* size,
    const uint8_t* usable,
    uint8_t* taken,
):
    """Take entities in order of the scalars they are coupled with, if no neighbour is taken."""
    cdef Py_ssize_t i, v, k, most = 0
    numbers = np.empty(2 * nb, dtype=np.int64)
    cdef int64_t* around = <int64_t*>writable(numbers, np.int64)
    cdef int64_t* order = around + nb
    for v in range(nb):
        around[v] = 0
        taken[v] = False
        for k in range(start[v], start[v + 1]):
            around[v] += size[other[k]]
        most = max(most, around[v])
    counts, marks = np.zeros(most + 2, dtype=np.int64), np.empty(nb, dtype=np.bool_)
    cdef int64_t* place = <int64_t*>writable(counts, np.int64)
    cdef uint8_t* closed = <uint8_t*>writable(marks, np.bool_)
    for v in range(nb):
        place[around[v] + 1] += 1
        closed[v] = not usable[v]
    for i in range(most + 1):
        place[i + 1] += place[i]
    for v in range(nb):
        order[place[around[v]]] = v
        place[around[v]] += 1
    for i in range(nb):
        v = order[i]
        if not closed[v]:
            taken[v] = closed[v] = True
            for k in range(start[v], start[v + 1]):
                closed[other[k]] = True
