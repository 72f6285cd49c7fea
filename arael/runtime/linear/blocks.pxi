"""Copying the row-major blocks of a matrix to column-major places."""

import numpy as np

from arael.runtime.address cimport address, writable

cdef extern from *:
    """
    #include <stddef.h>
    #include <string.h>

    #if defined(__GNUC__)
    #define COPY_INLINE static inline __attribute__((always_inline))
    #define COPY_UNROLL _Pragma("GCC unroll 9")
    #define COPY_SOON(at) __builtin_prefetch(at)
    #else
    #define COPY_INLINE static __forceinline
    #define COPY_UNROLL
    #define COPY_SOON(at)
    #endif

    /* Bits of a height or a width. */
    #define HALF 24
    #define AHEAD 4

    #define T double
    #define F(x) x##_f64
    #include "blocks.h"
    #undef T
    #undef F
    #define T float
    #define F(x) x##_f32
    #include "blocks.h"
    #undef T
    #undef F
    """
    enum: HALF
    void copy_blocks_f64(
        const long long* blocks, ptrdiff_t begin, ptrdiff_t end, const double* values,
        double* storage
    ) noexcept nogil
    void copy_blocks_f32(
        const long long* blocks, ptrdiff_t begin, ptrdiff_t end, const float* values,
        float* storage
    ) noexcept nogil


def table_of(first, height, width, place, leading, how):
    """Table for `put`.

    Parameters
    ----------
    first, height, width : (n,) int
        Offset of the block's values, and its size.
    place, leading : (n,) int
        Offset of its target, and the leading dimension there.
    how : (n,) int
        0 copy, 1 copy transposed, 2 copy the strict lower triangle.

    Returns
    -------
    (n, 4) int64
        First value, place, leading dimension, and the others packed into one number.
    """
    size = np.left_shift(np.asarray(how, dtype=np.int64), 2 * HALF)
    size |= np.left_shift(np.asarray(height, dtype=np.int64), HALF)
    size |= np.asarray(width, dtype=np.int64)
    return np.ascontiguousarray(np.stack((first, place, leading, size), axis=1), dtype=np.int64)


def block_table(pattern, Py_ssize_t leading):
    """Table for `put` that assembles the lower triangle as one matrix.

    Parameters
    ----------
    pattern : BlockPattern
    leading : int
        Entry (i, j) is stored at ``i + j * leading``.
    """
    cdef Py_ssize_t count = len(pattern.rows), nb = pattern.block_count, column, k
    cdef long long size
    # One pass: small systems are solved in microseconds.
    table = np.empty((count, 4), dtype=np.int64)
    cdef long long* to = <long long*>writable(table, np.int64)
    cdef const long long* start = <const long long*>address(pattern.column_start, np.int64)
    cdef const long long* rows = <const long long*>address(pattern.rows, np.int64)
    cdef const long long* sizes = <const long long*>address(pattern.sizes, np.int64)
    cdef const long long* offsets = <const long long*>address(pattern.offsets, np.int64)
    cdef const long long* values = <const long long*>address(pattern.value_start, np.int64)
    for column in range(nb):
        for k in range(start[column], start[column + 1]):
            size = <long long>(2 if rows[k] == column else 0) << (2 * HALF)
            size |= sizes[rows[k]] << HALF
            size |= sizes[column]
            to[0], to[1] = values[k], offsets[rows[k]] + offsets[column] * leading
            to[2], to[3] = leading, size
            to += 4
    return table


cdef void put(
    const long long* blocks, Py_ssize_t begin, Py_ssize_t end, const real* values, real* storage
) noexcept nogil:
    """Copy blocks `begin` to `end` of the table; diagonal entries are left to the caller."""
    if real is double:
        copy_blocks_f64(blocks, begin, end, values, storage)
    else:
        copy_blocks_f32(blocks, begin, end, values, storage)
