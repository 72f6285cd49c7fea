"""Blocks that the instances of a group couple, and offsets of their contributions.

Called a few times per group and once per pattern: a problem of few unknowns may have as many groups
as rows, and NumPy takes a microsecond or more for each operation on each of them.
"""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.address cimport address, writable

from arael.runtime.compiled import read_only


cdef const int64_t* ints(array, Py_ssize_t least=0) except? NULL:
    return <const int64_t*>address(array, np.int64, least)


def used_rows(list ways, list blocks, Py_ssize_t n, Py_ssize_t nowhere):
    """Rows, scalars and blocks of the entities that `n` instances use.

    Parameters
    ----------
    ways : per use, (n,) int64 rows of the instances
    blocks : per use, the `EntityBlocks` of its entity
    nowhere : scalar that stands for what is not solved for

    Returns
    -------
    rows : (n, uses) int32
    gradient_at : (n, uses) int32, first scalar, or `nowhere`
    block : (n, uses) int64, block, or -1
    """
    cdef Py_ssize_t uses = len(ways), u, k, row, size
    cdef const int64_t* way
    cdef const int64_t* first
    cdef const int64_t* number
    rows = np.empty((n, uses), dtype=np.int32)
    gradient_at = np.empty((n, uses), dtype=np.int32)
    block = np.empty((n, uses), dtype=np.int64)
    cdef int32_t* to_row = <int32_t*>writable(rows, np.int32)
    cdef int32_t* to_scalar = <int32_t*>writable(gradient_at, np.int32)
    cdef int64_t* to_block = <int64_t*>writable(block, np.int64)
    for u in range(uses):
        way = <const int64_t*>address(ways[u], np.int64, n)
        size = len(blocks[u].first)
        first, number = ints(blocks[u].first), ints(blocks[u].block)
        for k in range(n):
            row = way[k]
            if not 0 <= row < size:
                raise IndexError(f"row {row} of {size}")
            to_row[k * uses + u] = <int32_t>row
            to_scalar[k * uses + u] = <int32_t>(first[row] if first[row] >= 0 else nowhere)
            to_block[k * uses + u] = number[row]
    return rows, gradient_at, block


def common_ends(list now, list before, Py_ssize_t count, Py_ssize_t count_before):
    """How many instances at the beginning, and at the end, read the rows that they read before.

    Parameters
    ----------
    now, before : per use, int64 rows of the instances
    count, count_before : instances

    Returns
    -------
    first, last : instances; none is in both
    """
    cdef Py_ssize_t first = min(count, count_before), last, k
    cdef const int64_t* new
    cdef const int64_t* old
    for one, other in zip(now, before):
        new, old = ints(one, count), ints(other, count_before)
        k = 0
        while k < first and new[k] == old[k]:
            k += 1
        first = k
    last = min(count, count_before) - first
    for one, other in zip(now, before):
        new, old = ints(one, count) + count - 1, ints(other, count_before) + count_before - 1
        k = 0
        while k < last and new[-k] == old[-k]:
            k += 1
        last = k
    return first, last


def add_counts(counts, block_at, turn, Py_ssize_t nowhere, int sign):
    """Count how often instances add to each block of a pattern that is not on its diagonal.

    Parameters
    ----------
    counts : (nowhere + 1,) int32, by the place of a block in the values; changed
    block_at, turn : (n, pairs) int64 and uint8, as `Placement` has them
    nowhere : place of what is not solved for
    sign : 1, or -1 to take them away

    Returns
    -------
    Whether each of these blocks has some left.
    """
    cdef Py_ssize_t n = block_at.shape[0], pairs = block_at.shape[1], _, a, b, p
    cdef const int64_t* at = ints(block_at)
    cdef const uint8_t* how = <const uint8_t*>address(turn, np.uint8, n * pairs)
    cdef int32_t* count = <int32_t*>writable(counts, np.int32, nowhere + 1)
    cdef bint some = True
    for _ in range(n):
        p = a = 0
        while p < pairs:
            for b in range(a + 1):
                if b < a and how[p] != 2 and at[p] != nowhere:
                    if not 0 <= at[p] < nowhere:
                        raise IndexError(f"place {at[p]} of {nowhere}")
                    count[at[p]] += sign
                    some &= count[at[p]] > 0
                p += 1
            a += 1
        at += pairs
        how += pairs
    return some


def uses_and_keys(groups, coupled, slot_rows, active, blocks, Py_ssize_t nb, Py_ssize_t nowhere):
    """What the active instances of all groups use, and the pairs of blocks that they couple.

    Parameters
    ----------
    groups : of the layout
    coupled : per group (pairs,) uint8, whether some residual reads both uses of a pair
    slot_rows : per group, (n,) int64 rows of each slot
    active : per group, its n active rows
    blocks : `EntityBlocks` of each entity
    nb : blocks of the system
    nowhere : scalar that stands for what is not solved for

    Returns
    -------
    used : per group (rows, gradient_at, block), (n, uses) int32, int32, int64
        Row, first scalar (or `nowhere`) and block (or -1) of each entity that an instance uses.
    keys : (m,) int64, ``lower * nb + higher`` of all pairs of blocks that instances couple
    behind : how often the leads stand behind other uses in the system, less how often before
    """
    cdef Py_ssize_t extent = 0, count = 0, uses, behind = 0
    used = []
    for group, ways, rows in zip(groups, slot_rows, active):
        of = [np.ascontiguousarray(ways[use.slot]) for use in group.uses]
        one = used_rows(of, [blocks[use.entity] for use in group.uses], len(rows), nowhere)
        used.append(one)
        uses = len(of)
        extent += <Py_ssize_t>len(rows) * (uses * (uses - 1) // 2)
        if group.lead:
            behind += leads_behind(one[2], group.lead[0])
    keys = np.empty(extent, dtype=np.int64)
    for (_, _, block), chosen in zip(used, coupled):
        count = add_keys(block, chosen, nb, keys, count)
    return used, keys if count == extent else keys[:count], behind


cdef Py_ssize_t add_keys(block, coupled, Py_ssize_t nb, keys, Py_ssize_t count) except -1:
    """Append ``lower * nb + higher`` of all pairs of blocks that instances couple.

    Parameters
    ----------
    block : (n, uses) int64
    coupled : (pairs,) uint8, whether some residual reads both uses of a pair
    nb : blocks of the system
    keys : int64, with space for all pairs of all instances
    count : keys that are there already

    Returns
    -------
    Keys that are there now.
    """
    cdef Py_ssize_t n = block.shape[0], uses = block.shape[1], _, a, b
    cdef const int64_t* at = ints(block)
    cdef const uint8_t* chosen = <const uint8_t*>address(coupled, np.uint8, uses * (uses + 1) // 2)
    cdef int64_t* found = <int64_t*>writable(keys, np.int64, count + n * uses * (uses - 1) // 2)
    cdef int64_t i, j
    with nogil:
        for _ in range(n):
            for a in range(uses):
                i = at[a]
                if i < 0:
                    continue
                for b in range(a):
                    j = at[b]
                    if j >= 0 and i != j and chosen[a * (a + 1) // 2 + b]:
                        found[count] = i * nb + j if i < j else j * nb + i
                        count += 1
            at += uses
    return count


def leads_behind(block, Py_ssize_t lead):
    """How often the use `lead` stands behind another one in the system, less how often before."""
    cdef Py_ssize_t n = block.shape[0], uses = block.shape[1], _, u, found = 0
    cdef const int64_t* at = ints(block)
    with nogil:
        for _ in range(n):
            if at[lead] >= 0:
                for u in range(uses):
                    if at[u] >= 0:
                        found += (at[lead] > at[u]) - (at[lead] < at[u])
            at += uses
    return found


def has_blocks(pattern, keys):
    """Whether a pattern has the blocks of all keys, and no others but those on the diagonal.

    Parameters
    ----------
    keys : (m,) int64, as `pattern_arrays` takes them
    """
    cdef Py_ssize_t nb = len(pattern.sizes), m = len(keys), column, k = 0, at
    cdef const int64_t* key = ints(keys)
    cdef const int64_t* start = ints(pattern.column_start, nb + 1)
    cdef const int64_t* rows = ints(pattern.rows)
    cdef int64_t last
    for column in range(nb):
        at, last = start[column], column
        while k < m and key[k] < (column + 1) * nb:
            if key[k] - column * nb != last:
                at += 1
                if at == start[column + 1] or rows[at] != key[k] - column * nb:
                    return False
                last = rows[at]
            k += 1
        if at + 1 != start[column + 1]:
            return False
    return k == m


def pattern_arrays(sizes, keys, bint by_rows):
    """Columns, rows and places of the blocks of a pattern.

    Parameters
    ----------
    sizes : (nb,) int64
    keys : (m,) int64, ascending: ``lower * nb + higher`` of each pair that is coupled, repeated or
        not; diagonal blocks may be among them
    by_rows : whether values lie by block rows instead of by columns

    Returns
    -------
    column_start, rows, value_start, offsets, size : as `BlockPattern` has them
    value_count : scalars of all blocks
    """
    cdef Py_ssize_t nb = len(sizes), m = len(keys), column, k = 0, count = 0
    cdef const int64_t* size = ints(sizes)
    cdef const int64_t* key = ints(keys)
    cdef int64_t row, last, end = 0
    column_start = np.empty(nb + 1, dtype=np.int64)
    rows = np.empty(nb + m, dtype=np.int64)
    begins = np.zeros(nb + 1, dtype=np.int64)
    cdef int64_t* start = <int64_t*>writable(column_start, np.int64)
    cdef int64_t* to = <int64_t*>writable(rows, np.int64)
    cdef int64_t* begin = <int64_t*>writable(begins, np.int64)
    for column in range(nb):
        start[column] = count
        to[count] = last = column
        count += 1
        while k < m and key[k] < (column + 1) * nb:
            row = key[k] - column * nb
            if row != last:
                to[count] = last = row
                count += 1
            k += 1
    start[nb] = count
    rows = rows[:count]
    value_start = np.empty(count, dtype=np.int64)
    cdef int64_t* place = <int64_t*>writable(value_start, np.int64)
    if by_rows:
        for column in range(nb):
            for k in range(start[column], start[column + 1]):
                begin[to[k] + 1] += size[column] * size[to[k]]
        for column in range(nb):
            begin[column + 1] += begin[column]
        for column in range(nb):
            for k in range(start[column], start[column + 1]):
                place[k] = begin[to[k]]
                begin[to[k]] += size[column] * size[to[k]]
    else:
        for column in range(nb):
            for k in range(start[column], start[column + 1]):
                place[k] = end
                end += size[column] * size[to[k]]
        begin[nb] = end
    offsets = np.empty(nb + 1, dtype=np.int64)
    cdef int64_t* offset = <int64_t*>writable(offsets, np.int64)
    offset[0] = 0
    for column in range(nb):
        offset[column + 1] = offset[column] + size[column]
    return column_start, rows, value_start, offsets, offset[nb], begin[nb]


def places_of(pattern):
    """(blocks, 5) first row, first column, height, width and place of each block of a pattern."""
    cdef Py_ssize_t count = len(pattern.rows), column, k
    table = np.empty((count, 5), dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(table, np.int64)
    cdef const int64_t* start = ints(pattern.column_start)
    cdef const int64_t* rows = ints(pattern.rows)
    cdef const int64_t* sizes = ints(pattern.sizes)
    cdef const int64_t* offsets = ints(pattern.offsets)
    cdef const int64_t* places = ints(pattern.value_start)
    for column in range(pattern.block_count):
        for k in range(start[column], start[column + 1]):
            to[0], to[1] = offsets[rows[k]], offsets[column]
            to[2], to[3], to[4] = sizes[rows[k]], sizes[column], places[k]
            to += 5
    read_only(table)
    return table


def diagonal_of(pattern):
    """(n,) int64 offset in the values of each diagonal scalar of a pattern."""
    cdef Py_ssize_t nb = pattern.block_count, column, k, size
    cdef const int64_t* sizes = ints(pattern.sizes)
    cdef const int64_t* start = ints(pattern.column_start)
    cdef const int64_t* place = ints(pattern.value_start)
    found = np.empty(pattern.size, dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(found, np.int64)
    for column in range(nb):
        size = sizes[column]
        for k in range(size):
            to[k] = place[start[column]] + k * (size + 1)
        to += size
    return found


def rows_and_columns(pattern, scalars):
    """Offsets of all values in the rows and columns of some scalars, their diagonals excepted.

    Parameters
    ----------
    pattern : BlockPattern
    scalars : (m,) int64, each once

    Returns
    -------
    start : (m + 1,) int64, where each scalar's offsets begin
    positions : int64, the offsets
    """
    if not len(scalars):
        return np.zeros(1, dtype=np.int64), np.empty(0, dtype=np.int64)
    cdef Py_ssize_t nb = pattern.block_count, m = len(scalars), column, block, k, i, j, row
    cdef int64_t width, height, at
    cdef int pass_
    cdef const int64_t* sizes = ints(pattern.sizes)
    cdef const int64_t* begin = ints(pattern.column_start)
    cdef const int64_t* rows = ints(pattern.rows)
    cdef const int64_t* place = ints(pattern.value_start)
    cdef const int64_t* offset = ints(pattern.offsets)
    numbers = np.full(pattern.size + 1, -1, dtype=np.int64)
    numbers[scalars] = np.arange(m)
    cdef const int64_t* number = ints(numbers)
    # Whether a block has one of the scalars: most have none, and are passed over.
    marks = np.zeros(nb + 1, dtype=np.uint8)
    marks[np.searchsorted(pattern.offsets, scalars, side="right") - 1] = 1
    cdef const uint8_t* marked = <const uint8_t*>address(marks, np.uint8)
    starts = np.zeros(m + 1, dtype=np.int64)
    ends = np.zeros(m + 1, dtype=np.int64)
    cdef int64_t* start = <int64_t*>writable(starts, np.int64)
    cdef int64_t* end = <int64_t*>writable(ends, np.int64)
    positions = np.empty(0, dtype=np.int64)
    cdef int64_t* to = NULL
    for pass_ in range(2):  # count, then fill
        for column in range(nb):
            width = sizes[column]
            for block in range(begin[column], begin[column + 1]):
                row = rows[block]
                if not (marked[row] or marked[column]):
                    continue
                height = sizes[row]
                for i in range(height):
                    for j in range(width):
                        if row == column and i == j:
                            continue
                        at = place[block] + i * width + j
                        k = number[offset[row] + i]
                        if k >= 0:
                            if pass_:
                                to[end[k]] = at
                            end[k] += 1
                        k = number[offset[column] + j]
                        if k >= 0:
                            if pass_:
                                to[end[k]] = at
                            end[k] += 1
        if pass_ == 0:
            for k in range(m):
                start[k + 1] = start[k] + end[k]
            positions = np.empty(start[m], dtype=np.int64)
            to = <int64_t*>writable(positions, np.int64)
            for k in range(m):
                end[k] = start[k]
    return starts, positions


cdef inline Py_ssize_t found_in(
    const int64_t* rows, Py_ssize_t begin, Py_ssize_t end, int64_t row
) noexcept nogil:
    """Index of `row` in ascending rows; `end` if it is not there."""
    cdef Py_ssize_t middle, last = end
    while begin < end:
        middle = (begin + end) // 2
        if rows[middle] < row:
            begin = middle + 1
        else:
            end = middle
    return begin if begin < last and rows[begin] == row else last


def placed_pairs(block, coupled, pattern, Py_ssize_t nowhere, bint complete=True):
    """Offsets of the contributions of each instance in the values.

    Parameters
    ----------
    block : (n, uses) int64
    coupled : (pairs,) uint8, whether some residual reads both uses of a pair
    pattern : BlockPattern
        Has every block that is coupled.
    nowhere : place of what is not solved for
    complete : whether it is an error that the pattern lacks a block that is coupled

    Returns
    -------
    block_at : (n, pairs) int64
    turn : (n, pairs) uint8
        Or None, if the pattern lacks a block and need not be complete.
    """
    cdef Py_ssize_t n = block.shape[0], uses = block.shape[1], _, a, b, p, pairs, at
    pairs = uses * (uses + 1) // 2
    block_at = np.empty((n, pairs), dtype=np.int64)
    turn = np.empty((n, pairs), dtype=np.uint8)
    cdef const int64_t* one = ints(block)
    cdef const uint8_t* chosen = <const uint8_t*>address(coupled, np.uint8, pairs)
    cdef const int64_t* start = ints(pattern.column_start)
    cdef const int64_t* rows = ints(pattern.rows)
    cdef const int64_t* place = ints(pattern.value_start)
    cdef int64_t* to = <int64_t*>writable(block_at, np.int64)
    cdef uint8_t* how = <uint8_t*>writable(turn, np.uint8)
    cdef int64_t i, j
    cdef bint lost = False
    with nogil:
        for _ in range(n):
            p = 0
            for a in range(uses):
                i = one[a]
                for b in range(a + 1):
                    j = one[b]
                    to[p], how[p] = nowhere, 0
                    if i >= 0 and j >= 0 and chosen[p]:
                        if i == j:
                            to[p] = place[start[i]]
                        else:
                            at = found_in(rows, start[min(i, j)], start[min(i, j) + 1], max(i, j))
                            if at == start[min(i, j) + 1]:
                                lost = True
                            else:
                                to[p] = place[at]
                        if a != b:
                            how[p] = 2 if i == j else 1 if i < j else 0
                    p += 1
            one += uses
            to += pairs
            how += pairs
    if lost and not complete:
        return None
    if lost:
        raise ValueError("the pattern lacks a block that is coupled")
    return block_at, turn
