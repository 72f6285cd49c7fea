"""Single passes over rows: columns by instance, what refs and handles lead to, flags, lanes.

Small problems are prepared in microseconds, and NumPy takes one or more for each operation.
"""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t, uintptr_t
from libc.string cimport memcpy

from arael.runtime.address cimport address, writable

from arael.runtime.compiled import aligned_empty

ctypedef fused scalar:
    uint8_t
    int32_t
    int64_t


ctypedef fused number:
    double
    float
    int64_t
    uint8_t

# Bytes of a cache line.
cdef Py_ssize_t LINE = 64


cdef void take(
    const number* values, Py_ssize_t width, const int64_t* rows, Py_ssize_t n, double* found
) noexcept nogil:
    cdef Py_ssize_t k
    for k in range(n):
        found[k] = <double>values[rows[k] * width]


def taken(values, list components, rows):
    """Components of some rows, f64.

    Parameters
    ----------
    values : (size, width) or (size,), C order, f64, f32, int64 or bool
    components : columns of `values`
    rows : (n,) int64 rows

    Returns
    -------
    (len(components), n)
    """
    cdef Py_ssize_t n = len(rows), size = len(values), k, component
    cdef Py_ssize_t width = values.shape[1] if values.ndim > 1 else 1
    found = np.empty((len(components), n))
    if not n:
        return found
    cdef const int64_t* at = <const int64_t*>address(rows, np.int64, n)
    cdef const void* first = address(values, values.dtype, size * width)
    cdef double* to = <double*>writable(found, np.float64)
    for k in range(n):
        if not 0 <= at[k] < size:
            raise IndexError(f"row {at[k]} of {size}")
    kind = values.dtype.char
    for component in components:
        if not 0 <= component < width:
            raise IndexError(f"component {component} of {width}")
        if kind == "d":
            take(<const double*>first + component, width, at, n, to)
        elif kind == "f":
            take(<const float*>first + component, width, at, n, to)
        elif kind == "?":
            take(<const uint8_t*>first + component, width, at, n, to)
        elif values.dtype == np.int64:
            take(<const int64_t*>first + component, width, at, n, to)
        else:
            raise TypeError(f"expected numbers, found {values.dtype}")
        to += n
    return found


cdef void followed_rows(
    const int64_t* targets, const int64_t* rows, Py_ssize_t n, int64_t* found
) noexcept nogil:
    cdef Py_ssize_t k
    for k in range(n):
        found[k] = targets[rows[k]] if rows[k] >= 0 else -1


def followed(targets, rows):
    """(n,) int64, the target of each row, -1 where the row is negative.

    Parameters
    ----------
    targets : (size,) int64
    rows : (n,) int64, below `size`
    """
    cdef Py_ssize_t n = len(rows), size = len(targets), k
    cdef const int64_t* target = <const int64_t*>address(targets, np.int64)
    cdef const int64_t* row = <const int64_t*>address(rows, np.int64)
    found = np.empty(n, dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(found, np.int64)
    for k in range(n):
        if row[k] >= size:
            raise IndexError(f"row {row[k]} of {size}")
    followed_rows(target, row, n, to)
    return found


cdef void spread(
    const scalar* values, const int64_t* order, Py_ssize_t n, Py_ssize_t k, Py_ssize_t lanes,
    bint by_columns, scalar* found,
) noexcept nogil:
    cdef Py_ssize_t block, w, c, at, one
    cdef const scalar* row
    for block in range((n + lanes - 1) // lanes):
        at = block * lanes
        if by_columns and at + lanes > n:
            for w in range(lanes):
                one = min(at + w, n - 1)
                if order != NULL:
                    one = order[one]
                for c in range(k):
                    found[c * lanes + w] = values[c * n + one]
        elif by_columns and order == NULL:
            for c in range(k):
                memcpy(found + c * lanes, values + c * n + at, lanes * sizeof(scalar))
        elif by_columns:
            for c in range(k):
                for w in range(lanes):
                    found[c * lanes + w] = values[c * n + order[at + w]]
        else:
            for w in range(lanes):
                one = min(at + w, n - 1)
                row = values + k * (one if order == NULL else order[one])
                for c in range(k):
                    found[c * lanes + w] = row[c]
        found += k * lanes


cdef Py_ssize_t bytes_of_row(array, Py_ssize_t rows) except -1:
    """Bytes of one of at least so many rows (one or more)."""
    if len(array) < rows:
        raise ValueError(f"expected {rows} rows, found {len(array)}")
    return <Py_ssize_t>array.nbytes // <Py_ssize_t>len(array)


def join_columns(list columns, list starts, found):
    """Write columns side by side into rows; what they do not cover stays.

    Parameters
    ----------
    columns : (rows, ...) each
    starts : first scalar of each in a row of `found`
    found : (rows, width), C order
    """
    cdef Py_ssize_t rows = len(found), size = found.itemsize, k, wide, first, stride
    cdef char* target
    cdef char* to
    cdef const char* source
    if not rows:
        return
    stride = bytes_of_row(found, rows)
    target = <char*>writable(found, found.dtype)
    for column, start in zip(columns, starts):
        # Residuals of run time have their parameters in f64, also in a model of f32.
        column = np.ascontiguousarray(column, found.dtype)
        wide, first = bytes_of_row(column, rows), <Py_ssize_t>start * size
        if not 0 <= first <= stride - wide:
            raise IndexError(f"columns {start} and {wide // size} more of {stride // size}")
        source, to = <const char*>address(column, found.dtype), target + first
        for k in range(rows):
            memcpy(to + k * stride, source + k * wide, wide)


def split_columns(state, list starts, list columns, free, list firsts, list counts):
    """Write parts of rows into the columns they are of, where something of them moves.

    Parameters
    ----------
    state : (rows or more, width), C order
    starts : first scalar of each column in a row of `state`
    columns : (rows, ...) each, C order
    free : (rows, tangent) bool, which scalars move; None: all
    firsts, counts : of each column, the scalars of `free` that move it; a count of 0: nothing does
    """
    cdef Py_ssize_t size, stride, rows, wide, begin, k, j, tangent = 0, first, count
    cdef const char* from_
    cdef const uint8_t* moves = NULL
    cdef char* to
    cdef bint some
    if free is not None:
        moves, tangent = <const uint8_t*>address(free, np.bool_), free.shape[1]
    for column, start, one, several in zip(columns, starts, firsts, counts):
        rows, first, count = len(column), one, several
        if not (rows and count):
            continue
        alike = np.ascontiguousarray(state, column.dtype)
        size, stride = alike.itemsize, bytes_of_row(alike, rows)
        begin, wide = <Py_ssize_t>start * size, bytes_of_row(column, rows)
        if not 0 <= begin <= stride - wide:
            raise IndexError(f"scalars {start} and {wide // size} more of {stride // size}")
        if moves != NULL and not (len(free) >= rows and 0 <= first <= tangent - count):
            raise IndexError(f"flags {first} and {count} more of {tangent}")
        from_ = <const char*>address(alike, column.dtype) + begin
        to = <char*>writable(column, column.dtype)
        for k in range(rows):
            some = moves == NULL
            for j in range(first, 0 if some else first + count):
                some |= moves[k * tangent + j]
            if some:
                memcpy(to + k * wide, from_ + k * stride, wide)


def solved_scalars(list states, list flags, list widths):
    """The first scalars of all rows of which something moves, one after another, f64.

    Parameters
    ----------
    states : (rows or more, width) each, f64 or f32, C order
    flags : (rows, tangent) bool each, which scalars move
    widths : how many scalars of a row
    """
    cdef Py_ssize_t count = 0, at = 0, k, j, rows, width, stride, tangent
    cdef const uint8_t* moves
    cdef const double* wide
    cdef const float* narrow
    cdef bint some
    for free, taken_of in zip(flags, widths):
        count += len(free) * <Py_ssize_t>taken_of
    found = np.empty(count)
    cdef double* to = <double*>writable(found, np.float64)
    for state, free, taken_of in zip(states, flags, widths):
        rows, tangent, width, stride = len(free), free.shape[1], taken_of, state.shape[1]
        if len(state) < rows or width > stride:
            raise IndexError(f"{rows} rows of {width} of shape {state.shape}")
        moves = <const uint8_t*>address(free, np.bool_)
        single = state.dtype == np.float32
        narrow = <const float*>address(state, np.float32) if single else NULL
        wide = NULL if single else <const double*>address(state, np.float64)
        for k in range(rows):
            some = False
            for j in range(k * tangent, (k + 1) * tangent):
                some |= moves[j]
            if not some:
                continue
            for j in range(width):
                to[at + j] = narrow[k * stride + j] if wide == NULL else wide[k * stride + j]
            at += width
    return found if at == count else found[:at].copy()


cdef const int64_t* checked_order(order, Py_ssize_t n) except? NULL:
    """Address of (n,) rows that are all there; NULL for None."""
    cdef Py_ssize_t at
    if order is None:
        return NULL
    cdef const int64_t* place = <const int64_t*>address(order, np.int64, n)
    for at in range(n):
        if not 0 <= place[at] < n:
            raise IndexError("the order names instances that are not there")
    return place


cdef int spread_into(
    values, const int64_t* place, Py_ssize_t lanes, void* target
) except -1:
    """Write rows (n, k) in the order of lanes."""
    cdef Py_ssize_t n = values.shape[0], k = values.shape[1]
    cdef bint by_columns = values.strides[0] == values.itemsize and k != 1
    cdef int size = values.itemsize
    if size not in (1, 4, 8):
        raise TypeError(f"expected scalars of 1, 4 or 8 bytes, found {values.dtype}")
    if not n or not k:
        return 0
    if by_columns:
        values = values.T
    if not values.flags.c_contiguous:
        values = np.ascontiguousarray(values)
    cdef const void* source = address(values, values.dtype)
    with nogil:
        if size == 8:
            spread(<const int64_t*>source, place, n, k, lanes, by_columns, <int64_t*>target)
        elif size == 4:
            spread(<const int32_t*>source, place, n, k, lanes, by_columns, <int32_t*>target)
        else:
            spread(<const uint8_t*>source, place, n, k, lanes, by_columns, <uint8_t*>target)
    return 0


def spread_rows(values, Py_ssize_t lanes, order=None):
    """Rows (n, k) of `values` in the order of lanes.

    Parameters
    ----------
    values : (n, k), C or Fortran order, of 1, 4 or 8 bytes
    lanes : rows of a block
    order : (n,) int64 rows in the order of the lanes; None: as they come

    Returns
    -------
    (blocks, k, lanes) of the type of `values`; the last block is padded by the last instance.
    Begins on a cache line if there is more than one block.
    """
    cdef Py_ssize_t n = values.shape[0], blocks = (n + lanes - 1) // lanes
    if order is not None:
        order = np.ascontiguousarray(order, dtype=np.int64)
    shape, dtype = (blocks, values.shape[1], lanes), values.dtype
    found = aligned_empty(shape, dtype) if blocks > 1 else np.empty(shape, dtype)
    spread_into(values, checked_order(order, n), lanes, writable(found, dtype))
    return found


def spread_all(arrays, Py_ssize_t lanes, order=None, known=None, Py_ssize_t kept=0):
    """What `spread_rows` gives of each of several arrays, read-only and in one piece of memory.

    Parameters
    ----------
    arrays : of (n, k) each, with the same n
    known : what was found earlier of arrays whose first rows are the same
    kept : blocks that are copied from `known`; there is no order then
    """
    cdef Py_ssize_t n = len(arrays[0]), blocks = (n + lanes - 1) // lanes, extent = 0, skip, size
    cdef const void* source
    if kept and (order is not None or not 0 <= kept <= n // lanes):
        raise ValueError(f"cannot keep {kept} of {blocks} blocks")
    if order is not None:
        order = np.ascontiguousarray(order, dtype=np.int64)
    cdef const int64_t* place = checked_order(order, n)
    begins = []
    for values in arrays:
        if len(values) != n:
            raise ValueError(f"expected {n} rows, found {len(values)}")
        begins.append(extent)
        extent += (blocks * lanes * <Py_ssize_t>values.shape[1] * <Py_ssize_t>values.itemsize
                   + LINE - 1) // LINE * LINE
    raw = np.empty(extent + LINE, dtype=np.uint8)
    cdef char* first = <char*>writable(raw, np.uint8)
    skip = -<uintptr_t>first % LINE
    for k, (values, begin) in enumerate(zip(arrays, begins)):
        size = kept * lanes * <Py_ssize_t>values.shape[1] * <Py_ssize_t>values.itemsize
        if size:
            # Of the type and shape that is written here, and as many blocks as are kept.
            source = address(
                known[k], values.dtype, kept * lanes * <Py_ssize_t>values.shape[1])
            if known[k].shape[1:] != (values.shape[1], lanes):
                raise ValueError("what is kept has another shape")
            memcpy(first + skip + <Py_ssize_t>begin, source, size)
        spread_into(
            values[kept * lanes:], place, lanes, first + skip + <Py_ssize_t>begin + size)
    raw.setflags(write=False)
    return [
        np.ndarray((blocks, values.shape[1], lanes), values.dtype, raw, skip + begin)
        for values, begin in zip(arrays, begins)
    ]


def rows_of_handles(handles, positions, generations, int64_t start, int shift):
    """(n,) int64, rows of the slots of `handles`; -1 for null and stale ones.

    Parameters
    ----------
    handles : (n,) int64, a generation above a slot of `shift` bits; negative: null
    positions : (slots,) int64, position of each slot's row, negative if it has none
    generations : (slots,) int64
    start : position of the first row
    """
    cdef Py_ssize_t n = len(handles), used = len(positions), k
    cdef const int64_t* handle = <const int64_t*>address(handles, np.int64)
    cdef const int64_t* position = <const int64_t*>address(positions, np.int64)
    cdef const int64_t* generation = <const int64_t*>address(generations, np.int64, used)
    found = np.empty(n, dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(found, np.int64)
    cdef int64_t slot, mask = (<int64_t>1 << shift) - 1
    with nogil:
        for k in range(n):
            to[k] = -1
            slot = handle[k] & mask
            if handle[k] >= 0 and slot < used and generation[slot] == handle[k] >> shift:
                if position[slot] >= 0:
                    to[k] = position[slot] - start
    return found


def rows_where(Py_ssize_t n, list required, list refused):
    """(n,) bool, whether all of the flags `required` are set in a row and none of `refused`.

    Parameters
    ----------
    required, refused : (n,) bool arrays
    """
    cdef Py_ssize_t k
    cdef const uint8_t* flag
    found = np.ones(n, dtype=np.bool_)
    cdef uint8_t* to = <uint8_t*>writable(found, np.bool_)
    for one in required:
        flag = <const uint8_t*>address(one, np.bool_, n)
        for k in range(n):
            to[k] &= flag[k]
    for one in refused:
        flag = <const uint8_t*>address(one, np.bool_, n)
        for k in range(n):
            to[k] &= not flag[k]
    return found


def spread_flags(flags, scalars, Py_ssize_t first, Py_ssize_t count):
    """Set `count` columns of `scalars` (n, width) from `first` on to the flags (n,) of the rows."""
    cdef Py_ssize_t n = len(flags), width = scalars.shape[1], k, c
    if not 0 <= first <= first + count <= width:
        raise IndexError(f"columns {first} to {first + count} of {width}")
    cdef const uint8_t* flag = <const uint8_t*>address(flags, np.bool_)
    cdef uint8_t* to = <uint8_t*>writable(scalars, np.bool_, n * width)
    for k in range(n):
        for c in range(first, first + count):
            to[k * width + c] = flag[k]


def all_set(flags):
    """Whether all of some flags are set; of none they are not."""
    cdef Py_ssize_t n = flags.size, k
    cdef const uint8_t* flag = <const uint8_t*>address(flags, np.bool_)
    for k in range(n):
        if not flag[k]:
            return False
    return n > 0


def numbered(list flags):
    """Number the rows of which a scalar moves, and their scalars, of several tables in turn.

    Parameters
    ----------
    flags : (n, width) bool of each table, scalars that move

    Returns
    -------
    rows : (first, number, every) of each table
        (n,) int64 first scalar of each row, or -1 of a row in which nothing moves; (n,) int64 its
        number, or -1; whether all scalars of all rows move, and there are some.
    sizes : (rows that are numbered,) int64, scalars of each
    held : int64, scalars of these rows that do not move, ascending
    starts : number of the first scalar of each table
    count : scalars of all rows that are numbered
    """
    cdef Py_ssize_t n, width, k, c, moving, some, block = 0, scalar = 0, kept = 0, extent = 0
    cdef const uint8_t* flag
    cdef int64_t* first
    cdef int64_t* number
    for one in flags:
        extent += <Py_ssize_t>len(one)
    all_sizes = np.empty(extent, dtype=np.int64)
    cdef int64_t* size = <int64_t*>writable(all_sizes, np.int64)
    rows, starts = [], []
    for one in flags:
        n, width = one.shape[0], one.shape[1]
        flag = <const uint8_t*>address(one, np.bool_)
        both = np.empty((2, n), dtype=np.int64)
        first = <int64_t*>writable(both, np.int64)
        number = first + n
        starts.append(scalar)
        some = 0
        for k in range(n):
            moving = 0
            for c in range(width):
                moving += flag[k * width + c]
            some += moving
            first[k] = number[k] = -1
            if moving:
                first[k], number[k], size[block] = scalar, block, width
                scalar += width
                block += 1
                kept += width - moving
        rows.append((both[0], both[1], n * width == some > 0))
    held = np.empty(kept, dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(held, np.int64)
    for one, (firsts, _, every) in zip(flags, rows):
        if not kept or every:
            continue
        n, width = one.shape[0], one.shape[1]
        flag = <const uint8_t*>address(one, np.bool_)
        first = <int64_t*>writable(firsts, np.int64)
        for k in range(n):
            for c in range(width if first[k] >= 0 else 0):
                if not flag[k * width + c]:
                    to[0] = first[k] + c
                    to += 1
    return rows, all_sizes if block == extent else all_sizes[:block].copy(), held, starts, scalar


def some_set(flags):
    """(n,) bool, whether some of the flags (n, width) of a row are set."""
    cdef Py_ssize_t n = flags.shape[0], width = flags.shape[1], k, c
    cdef const uint8_t* flag = <const uint8_t*>address(flags, np.bool_)
    found = np.zeros(n, dtype=np.bool_)
    cdef uint8_t* to = <uint8_t*>writable(found, np.bool_)
    for k in range(n):
        for c in range(width):
            to[k] |= flag[k * width + c]
    return found


def held_of(list flags, list firsts):
    """What is held of rows that were numbered when others of their scalars moved.

    Parameters
    ----------
    flags : (n, width) bool of each table, scalars that move
    firsts : (n,) int64 of each table, as `numbered` gives it

    Returns
    -------
    held : int64, scalars of numbered rows that do not move, ascending; None if something moves in a
        row that has no number
    idle : numbered rows in which nothing moves
    """
    cdef Py_ssize_t n, width, k, c, moving, kept = 0, idle = 0
    cdef const uint8_t* flag
    cdef const int64_t* first
    cdef int64_t* to = NULL
    cdef int pass_
    held = None
    for pass_ in range(2):  # count, then fill
        if pass_:
            held = np.empty(kept, dtype=np.int64)
            to = <int64_t*>writable(held, np.int64)
        for one, begins in zip(flags, firsts):
            n, width = one.shape[0], one.shape[1]
            flag = <const uint8_t*>address(one, np.bool_)
            first = <const int64_t*>address(begins, np.int64, n)
            for k in range(n):
                moving = 0
                for c in range(width):
                    moving += flag[k * width + c]
                if first[k] < 0:
                    if moving:
                        return None, 0
                elif pass_ == 0:
                    kept += width - moving
                    idle += moving == 0
                elif moving < width:
                    for c in range(width):
                        if not flag[k * width + c]:
                            to[0] = first[k] + c
                            to += 1
    return held, idle
