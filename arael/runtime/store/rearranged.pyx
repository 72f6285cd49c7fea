# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Columns of rows by instance, and rows by instance in the order of lanes."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t, uintptr_t

from arael.runtime.address cimport address, writable

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


def aligned_empty(tuple shape, dtype):
    """Array of undefined content that begins on a cache line."""
    cdef Py_ssize_t size = dtype.itemsize, skip
    for length in shape:
        size *= <Py_ssize_t>length
    raw = np.empty(size + LINE, dtype=np.uint8)
    skip = -<uintptr_t>address(raw, np.uint8) % LINE
    return raw[skip : skip + size].view(dtype).reshape(shape)


cdef void take(
    const number* values, Py_ssize_t width, const int64_t* rows, Py_ssize_t n, double* found
) noexcept nogil:
    cdef Py_ssize_t k
    for k in range(n):
        found[k] = <double>values[rows[k] * width]


def taken(values, Py_ssize_t component, rows):
    """One component of some rows, f64.

    Parameters
    ----------
    values : (size, width), C order, f64, f32, int64 or bool
    component : column of `values`
    rows : (n,) int64 rows
    """
    cdef Py_ssize_t n = len(rows), size = values.shape[0], width = values.shape[1], k
    found = np.empty(n)
    if not n:
        return found
    cdef const int64_t* at = <const int64_t*>address(rows, np.int64, n)
    cdef const void* first = address(values, values.dtype, size * width)
    cdef double* to = <double*>writable(found, np.float64, n)
    if not 0 <= component < width:
        raise IndexError(f"component {component} of {width}")
    for k in range(n):
        if not 0 <= at[k] < size:
            raise IndexError(f"row {at[k]} of {size}")
    kind = values.dtype.char
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
    return found


cdef void spread(
    const scalar* values, const int64_t* order, Py_ssize_t n, Py_ssize_t k, Py_ssize_t lanes,
    scalar* found,
) noexcept nogil:
    cdef Py_ssize_t blocks = (n + lanes - 1) // lanes, block, w, c, at
    cdef const scalar* row
    for block in range(blocks):
        for w in range(lanes):
            at = min(block * lanes + w, n - 1)
            if order != NULL:
                at = order[at]
            row = values + at * k
            for c in range(k):
                found[c * lanes + w] = row[c]
        found += k * lanes


def spread_rows(values, Py_ssize_t lanes, order, found):
    """Fill `found` (blocks, k, lanes) with rows (n, k) of `values`, n > 0.

    Parameters
    ----------
    values : (n, k), C order, of 1, 4 or 8 bytes
    lanes : rows of a block
    order : (n,) int64 rows in the order of the lanes; None: as they come
    found : (blocks, k, lanes) of the type of `values`
        The last block is padded by the last instance.
    """
    cdef Py_ssize_t n = values.shape[0], k = values.shape[1], room
    cdef const int64_t* at = NULL
    room = (n + lanes - 1) // lanes * lanes * k
    if order is not None:
        order = np.ascontiguousarray(order, dtype=np.int64)
        if order.min() < 0 or order.max() >= n:
            raise IndexError("the order names instances that are not there")
        at = <const int64_t*>address(order, np.int64, n)
    cdef const void* source = address(values, values.dtype)
    cdef void* target = writable(found, values.dtype, room)
    cdef int size = values.dtype.itemsize
    with nogil:
        if size == 8:
            spread(<const int64_t*>source, at, n, k, lanes, <int64_t*>target)
        elif size == 4:
            spread(<const int32_t*>source, at, n, k, lanes, <int32_t*>target)
        elif size == 1:
            spread(<const uint8_t*>source, at, n, k, lanes, <uint8_t*>target)
    if size not in (1, 4, 8):
        raise TypeError(f"expected scalars of 1, 4 or 8 bytes, found {values.dtype}")
