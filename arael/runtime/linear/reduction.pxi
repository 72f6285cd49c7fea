"""The plan of a block elimination: eliminated entities, their couplings, places of the sums.

For every block (i, j) of the reduced system the plan lists all pairs of stored blocks whose product
is subtracted from it, so that a block is summed in registers and written once.
"""

import numpy as np

cimport cython
from libc.stdlib cimport qsort

from arael.runtime.assembly.pattern import BlockPattern

# Padded vectors are a multiple of this many scalars, in either precision.
PADDING = 16


cdef class Reduction:
    """Precomputed tables of an elimination.

    Attributes
    ----------
    pattern : BlockPattern
        Of the whole system.
    eliminated : (nb,) bool
    entities : (ne + 1,) ENTITY
        The eliminated entities, by size, with an end marker.
    couplings : (m,) COUPLING
        Stored blocks of each of them, by kept entity.
    entity_of : (m,) int64
        Entity of each coupling.
    scalars : (nr,) int64
        Scalar of the whole system of each scalar of the reduced one.
    padded : (nr,) int64
        Its place in a padded vector, which has `padded_size` scalars.
    factor_size, stored_size : int
        Scalars of all L and of all Z.
    """

    cdef readonly object pattern, eliminated, entities, couplings, entity_of, scalars, padded
    cdef readonly object kept, padded_size, factor_size, stored_size

    @property
    def sizes(self):
        """(nk,) scalars of the kept entities."""
        return np.asarray(self.pattern.sizes)[self.kept]


@cython.wraparound(True)
def reduce(pattern, eliminated):
    """Plan the elimination of a set of pairwise uncoupled entities.

    Parameters
    ----------
    pattern : BlockPattern
    eliminated : (nb,) bool

    Returns
    -------
    Reduction
    """
    cdef Reduction r = Reduction()
    sizes, offsets = np.asarray(pattern.sizes), np.asarray(pattern.offsets)
    r.pattern, r.eliminated = pattern, eliminated
    r.kept = np.flatnonzero(~eliminated)
    number = np.cumsum(~eliminated) - 1
    widths = sizes[r.kept]
    lengths = -(-widths // PADDING) * PADDING
    begin = np.concatenate(([0], np.cumsum(lengths))).astype(np.int64)
    r.padded_size = int(begin[-1])
    local = np.arange(int(widths.sum())) - np.repeat(np.cumsum(widths) - widths, widths)
    r.scalars = np.ascontiguousarray(np.repeat(offsets[r.kept], widths) + local, dtype=np.int64)
    r.padded = np.ascontiguousarray(np.repeat(begin[:-1], widths) + local, dtype=np.int64)

    columns = np.repeat(np.arange(len(sizes)), np.diff(pattern.column_start))
    mixed = np.flatnonzero(eliminated[pattern.rows] != eliminated[columns])
    turned = eliminated[columns[mixed]]
    away = np.where(turned, columns[mixed], pattern.rows[mixed])
    other = number[np.where(turned, pattern.rows[mixed], columns[mixed])]
    gone = _by_place(np.flatnonzero(eliminated), sizes, away, other)
    rank = np.zeros(len(sizes), dtype=np.int64)
    rank[gone] = np.arange(len(gone))
    entity = rank[away]
    sequence = np.argsort(entity * max(len(r.kept), 1) + other, kind="stable")
    entity, other = entity[sequence], other[sequence]

    d = sizes[gone]
    r.entities = np.zeros(len(gone) + 1, dtype=ENTITY)
    r.entities["scalar"][:-1] = offsets[gone]
    r.entities["source"][:-1] = pattern.value_start[pattern.column_start[gone]]
    r.entities["factor"] = np.concatenate(([0], np.cumsum(d * d)))
    r.entities["couplings"] = np.searchsorted(entity, np.arange(len(gone) + 1))
    r.entities["size"][:-1] = d
    area = d[entity] * widths[other]
    r.couplings = np.zeros(len(entity), dtype=COUPLING)
    r.couplings["source"] = pattern.value_start[mixed[sequence]]
    r.couplings["place"] = np.cumsum(area) - area
    r.couplings["padded"] = begin[other]
    r.couplings["width"] = widths[other]
    r.couplings["turned"] = turned[sequence]
    r.couplings["kept"] = other
    r.entity_of = np.ascontiguousarray(entity, dtype=np.int64)
    r.factor_size, r.stored_size = int((d * d).sum()), int(area.sum())
    return r


def _by_place(gone, sizes, away, other):
    """The eliminated entities by size, then by the first and last kept entity coupled with them.

    Contributions to one block of the reduced system are then close together in memory.
    """
    first = np.full(len(sizes), len(sizes), dtype=np.int64)
    last = np.full(len(sizes), -1, dtype=np.int64)
    np.minimum.at(first, away, other)
    np.maximum.at(last, away, other)
    return gone[np.lexsort((last[gone], first[gone], sizes[gone]))]


cdef class Products:
    """Blocks of a reduced system, and the sums for each.

    Attributes
    ----------
    pattern : BlockPattern
        Of the reduced system; its scalars are named as in the whole one.
    sources : (nblocks,) int64
        Offset of each block in the values of the whole system, -1 for fill-in.
    tasks : (nt, 6) int64
        Offset of a block in the reduced values, its height and width, the scalars of the eliminated
        entities, first pair and number of pairs.
    pairs : (np + slack, 2) int32
        Offsets of the two stored blocks.
    """

    cdef readonly object pattern, sources, tasks, pairs


cdef int _ascending(const void* a, const void* b) noexcept nogil:
    cdef long long x = (<const long long*>a)[0], y = (<const long long*>b)[0]
    return (x > y) - (x < y)


def products(Reduction r, group=None, reach=None):
    """Lay out the blocks of the reduced system, all or a part.

    Parameters
    ----------
    r : Reduction
    group : (nk,) int64, optional
        Only blocks that couple kept entities of the same group ...
    reach : int, optional
        ... or entities at most this far apart; by default all blocks.

    Returns
    -------
    Products
    """
    cdef Products p = Products()
    cdef Py_ssize_t nk = len(r.kept), i, j, k, o, first, count, total, block
    everything = group is None and reach is None
    cdef bint whole = everything
    cdef long long near = nk if reach is None and everything else (reach or 0)
    same_array = np.arange(nk + 1) if group is None else np.append(group, -1)
    cdef long long[::1] same = np.ascontiguousarray(same_array, dtype=np.int64)

    couplings = r.couplings
    by_kept = np.argsort(couplings["kept"], kind="stable")
    cdef long long[::1] of_kept = np.append(by_kept, 0).astype(np.int64)
    cdef long long[::1] kept_start = np.searchsorted(
        couplings["kept"][by_kept], np.arange(nk + 1)
    ).astype(np.int64)
    cdef int[::1] kept_of = np.append(couplings["kept"], 0).astype(np.int32)
    cdef int[::1] place = np.append(couplings["place"], 0).astype(np.int32)
    cdef long long[::1] entity_of = np.append(r.entity_of, 0)
    cdef long long[::1] ends = np.ascontiguousarray(r.entities["couplings"])
    cdef long long[::1] depth = np.ascontiguousarray(r.entities["size"])

    direct_rows, direct_start, direct_source = _direct(r)
    cdef long long[::1] direct = np.append(direct_rows, 0).astype(np.int64)
    cdef long long[::1] direct_begin = direct_start
    cdef long long[::1] direct_place = np.append(direct_source, 0).astype(np.int64)

    # Mark and list the blocks of each column: once to count them, once to store them.
    cdef long long[::1] stamp = np.full(nk + 1, -1, dtype=np.int64)
    cdef long long[::1] found = np.zeros(nk + 1, dtype=np.int64)
    cdef long long[::1] at = np.zeros(nk + 1, dtype=np.int64)
    column_array = np.zeros(nk + 1, dtype=np.int64)
    cdef long long[::1] column_start = column_array
    total = 0
    with nogil:
        for j in range(nk):
            count = 0
            for k in range(direct_begin[j], direct_begin[j + 1]):
                i = direct[k]
                if stamp[i] != j and (whole or i - j <= near or same[i] == same[j]):
                    stamp[i] = j
                    count += 1
            for k in range(kept_start[j], kept_start[j + 1]):
                first = of_kept[k]
                for o in range(first, ends[entity_of[first] + 1]):
                    i = kept_of[o]
                    if whole or i - j <= near or same[i] == same[j]:
                        total += 1
                        if stamp[i] != j:
                            stamp[i] = j
                            count += 1
            column_start[j + 1] = column_start[j] + count

    cdef Py_ssize_t blocks = column_start[nk]
    rows_array = np.zeros(blocks + 1, dtype=np.int64)
    sources_array = np.full(blocks + 1, -1, dtype=np.int64)
    pair_array = np.zeros((total + SLACK, 2), dtype=np.int32)
    pair_start = np.zeros(blocks + 1, dtype=np.int64)
    depth_array = np.zeros(total + 1, dtype=np.int32)
    cdef long long[::1] rows = rows_array, sources = sources_array, begin = pair_start
    cdef int[:, ::1] pairs = pair_array
    cdef int[::1] deep = depth_array
    stamp[:] = -1
    with nogil:
        for j in range(nk):
            count = 0
            for k in range(direct_begin[j], direct_begin[j + 1]):
                i = direct[k]
                if whole or i - j <= near or same[i] == same[j]:
                    stamp[i] = j
                    at[i] = 0
                    found[count] = i
                    count += 1
            for k in range(kept_start[j], kept_start[j + 1]):
                first = of_kept[k]
                for o in range(first, ends[entity_of[first] + 1]):
                    i = kept_of[o]
                    if whole or i - j <= near or same[i] == same[j]:
                        if stamp[i] != j:
                            stamp[i] = j
                            at[i] = 0
                            found[count] = i
                            count += 1
                        at[i] += 1
            qsort(&found[0], count, sizeof(long long), _ascending)
            block = column_start[j]
            for k in range(count):
                i = found[k]
                rows[block + k] = i
                begin[block + k + 1] = begin[block + k] + at[i]
                at[i] = begin[block + k]
                stamp[i] = block + k
            for k in range(direct_begin[j], direct_begin[j + 1]):
                i = direct[k]
                if whole or i - j <= near or same[i] == same[j]:
                    sources[stamp[i]] = direct_place[k]
            for k in range(kept_start[j], kept_start[j + 1]):
                first = of_kept[k]
                for o in range(first, ends[entity_of[first] + 1]):
                    i = kept_of[o]
                    if whole or i - j <= near or same[i] == same[j]:
                        pairs[at[i], 0] = place[o]
                        pairs[at[i], 1] = place[first]
                        deep[at[i]] = <int>depth[entity_of[first]]
                        at[i] += 1
            for k in range(count):
                stamp[found[k]] = -1
    p.pattern = _pattern(r, column_array, rows_array[:blocks])
    p.sources, p.pairs = sources_array, pair_array
    p.tasks = _tasks(p.pattern, pair_start, depth_array[:total])
    return p


def kept_blocks(Reduction r):
    """Blocks that couple kept entities directly, without any products.

    Returns
    -------
    Products
    """
    cdef Products p = Products()
    rows, begin, sources = _direct(r)
    p.pattern = _pattern(r, begin, rows)
    p.sources = np.append(sources, -1).astype(np.int64)
    p.tasks = np.zeros((0, 6), dtype=np.int64)
    p.pairs = np.zeros((SLACK, 2), dtype=np.int32)
    return p


def _direct(Reduction r):
    """Blocks that couple kept entities, by columns: rows, starts, offsets in the values."""
    pattern = r.pattern
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    chosen = np.flatnonzero(~r.eliminated[pattern.rows] & ~r.eliminated[columns])
    number = np.cumsum(~r.eliminated) - 1
    begin = np.searchsorted(columns[chosen], np.append(r.kept, pattern.block_count))
    return number[pattern.rows[chosen]], begin.astype(np.int64), pattern.value_start[chosen]


def _pattern(Reduction r, column_start, rows):
    sizes = r.sizes
    columns = np.repeat(np.arange(len(sizes)), np.diff(column_start))
    area = sizes[rows] * sizes[columns]
    name_of, scalars = r.pattern.name_of, r.scalars
    return BlockPattern(
        sizes,
        column_start,
        rows,
        np.cumsum(area) - area,
        lambda i: name_of(int(scalars[i])),
    )


@cython.wraparound(True)
def _tasks(pattern, pair_start, depth):
    """One task for each block and size of eliminated entity."""
    change = np.zeros(len(depth) + 1, dtype=bool)
    change[pair_start] = True
    change[1:-1] |= depth[1:] != depth[:-1]
    change[-1] = False
    first = np.flatnonzero(change)
    block = np.searchsorted(pair_start, first, side="right") - 1
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    parts = (
        pattern.value_start[block],
        pattern.sizes[pattern.rows[block]],
        pattern.sizes[columns[block]],
        depth[first],
        first,
        np.diff(np.append(first, len(depth))),
    )
    return np.ascontiguousarray(np.stack(parts, axis=1), dtype=np.int64)
