# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Copying the row-major blocks of a matrix to column-major places."""

import numpy as np


def block_table(pattern, Py_ssize_t leading):
    """Table for `put` that lays the lower triangle out as one matrix.

    Parameters
    ----------
    pattern : BlockPattern
    leading : int
        Entry (i, j) goes to ``i + j * leading``.

    Returns
    -------
    (nblocks, 6) int64
        First value, height, width, place, leading dimension there, and what to do: 0 copy, 1 copy
        transposed, 2 copy the strict lower triangle.
    """
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    offsets = pattern.offsets
    parts = (
        pattern.value_start,
        pattern.sizes[pattern.rows],
        pattern.sizes[columns],
        offsets[pattern.rows] + offsets[columns] * leading,
        np.full(len(columns), leading),
        np.where(pattern.rows == columns, 2, 0),
    )
    return np.ascontiguousarray(np.stack(parts, axis=1), dtype=np.int64)


cdef void* address(array):
    """Where the array's scalars are; the caller keeps the array."""
    cdef size_t place = array.ctypes.data
    return <void*>place


cdef void put(
    const long long* blocks, Py_ssize_t begin, Py_ssize_t end, const real* values, real* storage
) noexcept nogil:
    """Copy blocks `begin` to `end` of the table; diagonal entries are left to the caller."""
    cdef Py_ssize_t k, i, j, h, w, ld
    cdef const long long* block
    cdef const real* value
    cdef real* at
    for k in range(begin, end):
        block = blocks + 6 * k
        value, h, w = values + block[0], block[1], block[2]
        at, ld = storage + block[3], block[4]
        if block[5] == 0:
            for j in range(w):
                for i in range(h):
                    at[i + j * ld] = value[i * w + j]
        elif block[5] == 1:
            for i in range(h):
                for j in range(w):
                    at[j + i * ld] = value[i * w + j]
        else:
            for i in range(h):
                for j in range(i):
                    at[i + j * ld] = value[i * w + j]
