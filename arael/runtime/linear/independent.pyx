# cython: language_level=3, boundscheck=False, cdivision=True
"""Choice of an independent set of entities to eliminate first."""

import numpy as np

cimport cython

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.linear.symbolic import adjacency

# An entity with more couplings than this multiple of the average would fill the reduced system and
# is kept; entities with few couplings are always eliminated.
_HUB = 10
_FEW = 64


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
    nb = pattern.block_count
    sizes = np.asarray(pattern.sizes)
    start, neighbours = adjacency(pattern)
    degree = np.diff(start)
    often = max(_FEW, _HUB * (len(neighbours) / max(nb, 1)))
    usable = (sizes > 0) & (degree <= often)
    for size in np.flatnonzero(np.bincount(sizes, minlength=1) * 2 >= max(nb, 1)):
        kind = (sizes == size) & usable
        if size > 0 and kind.sum() * 2 >= nb and not _coupled(nb, start, neighbours, kind):
            return kind
    return _greedy(nb, start, neighbours, sizes, usable)


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


@cython.wraparound(False)
def _coupled(Py_ssize_t nb, starts, neighbours, chosen):
    """Whether two of the chosen entities are coupled."""
    cdef const long long[::1] start = starts, other = neighbours
    cdef const unsigned char[::1] inside = chosen.view(np.uint8)
    cdef Py_ssize_t v, k
    for v in range(nb):
        if inside[v]:
            for k in range(start[v], start[v + 1]):
                if inside[other[k]]:
                    return True
    return False


@cython.wraparound(False)
def _greedy(Py_ssize_t nb, starts, neighbours, sizes, usable):
    """Take entities in order of the scalars they are coupled with, if no neighbour is taken."""
    cdef const long long[::1] start = starts, other = neighbours, size = sizes
    cdef Py_ssize_t i, v, k
    coupled = np.zeros(nb, dtype=np.int64)
    cdef long long[::1] around = coupled
    for v in range(nb):
        for k in range(start[v], start[v + 1]):
            around[v] += size[other[k]]
    order_array = np.argsort(coupled, kind="stable").astype(np.int64)
    # 1 taken, 2 coupled with a taken one or not usable.
    state_array = np.append(np.where(usable, 0, 2), 0).astype(np.int8)
    cdef long long[::1] order = order_array
    cdef signed char[::1] state = state_array
    for i in range(nb):
        v = order[i]
        if state[v]:
            continue
        state[v] = 1
        for k in range(start[v], start[v + 1]):
            state[other[k]] = 2
    return state_array[:nb] == 1
