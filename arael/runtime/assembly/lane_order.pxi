"""The order of a group's instances, and where they add in the order of lanes; see `shares.py`."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport calloc, free

from arael.runtime.address cimport address, writable

from arael.runtime.compiled import read_only
from arael.runtime.store.compiled import spread_all

# Keys for each instance up to which they are counted; a comparison sort takes the others.
cdef Py_ssize_t SPREAD = 8


def keys_of(rows, Py_ssize_t lead, block_at, list others, Py_ssize_t nowhere):
    """(n,) int64: twice the row of the lead, and one more if its block was met before.

    Parameters
    ----------
    rows : (n, uses) int32
    lead : number of the use
    block_at : (n, pairs) int64, places up to `nowhere`
    others : pairs with the lead; the first that is solved for somewhere decides
    nowhere : place of what is not solved for
    """
    cdef Py_ssize_t n = rows.shape[0], uses = rows.shape[1], pairs = block_at.shape[1], k, pair
    cdef bint some
    cdef const int32_t* row = <const int32_t*>address(rows, np.int32)
    cdef const int64_t* at = <const int64_t*>address(block_at, np.int64, n * pairs)
    cdef uint8_t* seen
    cdef int64_t place
    if not 0 <= lead < uses:
        raise IndexError(f"use {lead} of {uses}")
    found = np.empty(n, dtype=np.int64)
    cdef int64_t* key = <int64_t*>writable(found, np.int64)
    for k in range(n):
        key[k] = 2 * <int64_t>row[k * uses + lead]
    for pair in others:
        if not 0 <= pair < pairs:
            raise IndexError(f"pair {pair} of {pairs}")
        some = False
        for k in range(n):
            place = at[k * pairs + pair]
            if not 0 <= place <= nowhere:
                raise IndexError(f"place {place} of {nowhere}")
            some |= place != nowhere
        if not some:
            continue
        seen = <uint8_t*>calloc(nowhere + 1, 1)
        if seen == NULL:
            raise MemoryError
        for k in range(n):
            place = at[k * pairs + pair]
            if place != nowhere:
                key[k] += seen[place]
                seen[place] = 1
        free(seen)
        break
    return found


def order_by(keys):
    """(n,) int64, stable order of keys (n,) int64; None if they are in order."""
    cdef Py_ssize_t n = len(keys), k
    cdef const int64_t* key = <const int64_t*>address(keys, np.int64)
    cdef int64_t least = 0, most = 0, place = 0, count
    cdef bint sorted_ = True
    cdef int64_t* ends
    for k in range(n):
        sorted_ &= k == 0 or key[k - 1] <= key[k]
        least, most = min(least, key[k]), max(most, key[k])
    if sorted_:
        return None
    if least < 0 or most > SPREAD * n:
        return np.argsort(keys, kind="stable")
    order = np.empty(n, dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(order, np.int64)
    ends = <int64_t*>calloc(most + 1, sizeof(int64_t))
    if ends == NULL:
        raise MemoryError
    for k in range(n):
        ends[key[k]] += 1
    for k in range(most + 1):
        count = ends[k]
        ends[k] = place
        place += count
    for k in range(n):
        to[ends[key[k]]] = k
        ends[key[k]] += 1
    free(ends)
    return order


def lane_targets(arrays, Py_ssize_t lanes, order, leads, known=None, Py_ssize_t kept=0):
    """Targets of a group in lane order, read-only, as `LaneTargets` has them, without `first`.

    Parameters
    ----------
    arrays : rows, gradient_at, block_at and turn of its instances, as `Placement` has them
    lanes : instances of a block
    order : (n,) int64 instances in the order of the lanes; None: as they come
    leads : of the group
    known : targets of the instances of before, without an order
    kept : blocks of lanes that are as in `known`
    """
    found = spread_all(arrays, lanes, order, None if known is None else known[:4], kept)
    run = shared_rows(found[0], leads, len(arrays[0]))
    read_only(run)
    return (*found, run)


def shared_rows(rows, leads, Py_ssize_t n):
    """(blocks,) uint8, whether all lanes of a block are instances of the same rows of the leads.

    Parameters
    ----------
    rows : (blocks, uses, lanes) int32
    leads : numbers of uses, none if there are no such uses
    n : instances; a block that is padded does not count
    """
    cdef Py_ssize_t blocks = rows.shape[0], uses = rows.shape[1], lanes = rows.shape[2], b, w, lead
    cdef const int32_t* row
    cdef bint same
    found = np.zeros(blocks, dtype=np.uint8)
    if not len(leads):
        return found
    cdef const int32_t* first = <const int32_t*>address(rows, np.int32)
    cdef uint8_t* to = <uint8_t*>writable(found, np.uint8)
    for b in range(min(n // lanes, blocks)):
        same = True
        for lead in leads:
            if not 0 <= lead < uses:
                raise IndexError(f"use {lead} of {uses}")
            row = first + (b * uses + lead) * lanes
            for w in range(1, lanes):
                same &= row[w] == row[0]
        to[b] = same
    return found
