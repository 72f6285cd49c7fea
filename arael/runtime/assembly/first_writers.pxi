"""Lanes that are the first to write a block, and what lies between such blocks; see `firsts.py`."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport calloc, free

from arael.runtime.address cimport address, writable

# Of `turn`: onto a diagonal block, of which there is more than the pair's own.
cdef uint8_t DIAGONAL = 2


# What is known of one place among the values.
cdef struct Place:
    int32_t step        # block of lanes that writes there first, from 1 on; 0: none
    int32_t area        # scalars of the block if it is stored, else 0
    int64_t start       # its first scalar
    uint8_t several     # whether several lanes of that block of lanes write there
    uint8_t nowhere     # whether it stands for what is not solved for


def find_firsts(list block_at, list turns, counts, list areas, order, may, nowhere, int64_t extent,
                int64_t near):
    """First writers of all off-diagonal pairs, and the ranges of values that they do not store.

    Parameters
    ----------
    block_at : per group, (blocks, pairs, lanes) int64, places in the values
    turns : per group, (blocks, pairs, lanes) uint8
    counts : instances by group
    areas : per group, scalars of the block of each pair; 0 for pairs of a use with itself
    order : groups in the order in which they write any one place
    may : by group, whether it may store
    nowhere : places of what is not solved for
    extent : scalars of the values
    near : gap up to which what is emptied is joined, in scalars

    Returns
    -------
    first : per group, (blocks, pairs) uint8
        Whether all lanes of a block are the first to write their places, each another one.
    between : (m, 2) int64, begin and end of what must be emptied
    """
    cdef Py_ssize_t places
    cdef int32_t step = 0
    cdef int64_t least = 0, at
    cdef Place* place
    first = [np.zeros((len(a), a.shape[1]), dtype=np.uint8) for a in block_at]
    # Blocks do not overlap: divided by the least of their areas, their offsets still differ.
    for one in areas:
        for area in one:
            if area and (not least or area < least):
                least = area
    if not least:
        return first, np.array([[0, extent]], dtype=np.int64)
    places = extent // least + 1
    place = <Place*>calloc(places, sizeof(Place))
    if place == NULL:
        raise MemoryError
    try:
        for at in nowhere:
            if not 0 <= at <= extent:
                raise IndexError(f"place {at} of {extent}")
            place[at // least].nowhere = True
        for g in order:
            check(block_at[g], turns[g], areas[g], counts[g], extent)
            visit(place, least, step, block_at[g], counts[g], areas[g])
            step += len(block_at[g])
        step = 0
        for g in order:
            if may[g]:
                choose(place, least, step, block_at[g], turns[g], counts[g], areas[g], first[g])
            step += len(block_at[g])
        return first, between(place, places, extent, near)
    finally:
        free(place)


cdef check(block_at, turn, areas, Py_ssize_t count, int64_t extent):
    """Raise unless the arrays of a group belong together and name places that are there."""
    cdef Py_ssize_t k
    cdef const int64_t* at = <const int64_t*>address(block_at, np.int64)
    if (block_at.shape != turn.shape or len(areas) != block_at.shape[1]
            or count > len(block_at) * block_at.shape[2]):
        raise ValueError("the arrays of a group differ in shape")
    for k in range(block_at.size):
        if not 0 <= at[k] <= extent:
            raise IndexError(f"place {at[k]} of {extent}")


cdef visit(
    Place* places, int64_t least, int32_t step, block_at, Py_ssize_t count, areas
):
    """Note the first writer of each place of a group."""
    cdef Py_ssize_t blocks = len(block_at), pairs = block_at.shape[1], lanes = block_at.shape[2]
    cdef Py_ssize_t block, pair, w
    cdef const int64_t* at = <const int64_t*>address(block_at, np.int64)
    chosen = np.array([area > 0 for area in areas], dtype=np.uint8)
    cdef const uint8_t* off = <const uint8_t*>address(chosen, np.uint8)
    cdef Place* place
    with nogil:
        for block in range(blocks):
            for pair in range(pairs):
                for w in range(min(lanes, count - block * lanes) if off[pair] else 0):
                    place = &places[at[w] // least]
                    if place.step == 0:
                        place.step = step + <int32_t>block + 1
                    elif place.step == step + block + 1:
                        place.several = True
                at += lanes


cdef choose(
    Place* places, int64_t least, int32_t step, block_at, turn, Py_ssize_t count, areas, first
):
    """Mark the pairs of the blocks of lanes that store, and the places where they do."""
    cdef Py_ssize_t blocks = len(block_at), pairs = block_at.shape[1], lanes = block_at.shape[2]
    cdef Py_ssize_t block, pair, w
    cdef const int64_t* at = <const int64_t*>address(block_at, np.int64)
    cdef const uint8_t* how = <const uint8_t*>address(turn, np.uint8)
    cdef uint8_t* to = <uint8_t*>writable(first, np.uint8)
    sizes = np.array(areas, dtype=np.int32)
    cdef const int32_t* area = <const int32_t*>address(sizes, np.int32)
    cdef Place* place
    cdef bint alone
    written = np.zeros(pairs, dtype=np.uint8)
    cdef uint8_t* use = <uint8_t*>writable(written, np.uint8)
    cdef const int64_t* look = at
    with nogil:
        # A pair that is solved for nowhere does not store.
        for block in range(blocks):
            for pair in range(pairs):
                if area[pair] and not use[pair]:
                    for w in range(min(lanes, count - block * lanes)):
                        use[pair] |= not places[look[w] // least].nowhere
                look += lanes
        for block in range(blocks):
            for pair in range(pairs):
                if use[pair]:
                    alone = True
                    for w in range(min(lanes, count - block * lanes)):
                        place = &places[at[w] // least]
                        if not place.nowhere:
                            alone &= (place.step == step + block + 1 and not place.several
                                      and how[w] != DIAGONAL)
                    to[pair] = alone
                    for w in range(min(lanes, count - block * lanes) if alone else 0):
                        place = &places[at[w] // least]
                        if not place.nowhere:
                            place.area, place.start = area[pair], at[w]
                at += lanes
                how += lanes
            to += pairs


cdef between(const Place* places, Py_ssize_t count, int64_t extent, int64_t near):
    """(m, 2) what lies between stored blocks, short ones of these included."""
    cdef Py_ssize_t k, stored = 0, rows = 0
    cdef int64_t low = 0, high = -1, end = 0, begin
    for k in range(count):
        stored += places[k].area > 0
    found = np.empty((stored + 1, 2), dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(found, np.int64)
    # A run of stored blocks is left out if it is long; otherwise it is emptied like the rest.
    for k in range(count + 1):
        if k < count and not places[k].area:
            continue
        begin = extent if k == count else places[k].start
        if begin > end or high < 0 or k == count:
            if high >= 0 and end - high >= near:
                if low < high:
                    to[2 * rows], to[2 * rows + 1] = low, high
                    rows += 1
                low = end
            high = begin
        if k < count:
            end = begin + places[k].area
    if low < high:
        to[2 * rows], to[2 * rows + 1] = low, high
        rows += 1
    return found[:rows]
