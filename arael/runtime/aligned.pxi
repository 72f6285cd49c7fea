"""Arrays that begin on a cache line."""

import numpy as np

from libc.stdint cimport uintptr_t

from arael.runtime.address cimport address

# Bytes of a cache line.
cdef Py_ssize_t LINE = 64


def aligned_empty(tuple shape, dtype):
    """Array of undefined content that begins on a cache line."""
    cdef Py_ssize_t size = dtype.itemsize, skip
    for length in shape:
        size *= <Py_ssize_t>length
    raw = np.empty(size + LINE, dtype=np.uint8)
    skip = -<uintptr_t>address(raw, np.uint8) % LINE
    return np.ndarray(shape, dtype, raw, skip)  # one call for a slice, a view and a shape


def aligned_zeros(Py_ssize_t count, dtype):
    """Zeros, `count` scalars and a cache line of padding."""
    kind = np.dtype(dtype)
    cdef Py_ssize_t slack = LINE // <Py_ssize_t>kind.itemsize
    raw = np.zeros((count + 2 * slack) * kind.itemsize, dtype=np.uint8)
    cdef Py_ssize_t skip = -<uintptr_t>address(raw, np.uint8) % LINE
    return np.ndarray((count + slack,), kind, raw, skip)


def aligned_parts(counts, dtype):
    """Arrays of undefined content in one piece of memory, each on cache lines of its own.

    For what is written before it is read: to empty a megabyte takes as long as to factorise it.

    Parameters
    ----------
    counts : scalars of each; a cache line of padding follows

    Returns
    -------
    list of arrays (count + scalars of a cache line,)
    """
    cdef Py_ssize_t size = dtype.itemsize, slack = LINE // size, extent = 0, skip, count
    for count in counts:
        extent += (count + slack - 1) // slack * LINE + LINE
    raw = np.empty(extent + LINE, dtype=np.uint8)
    skip = -<uintptr_t>address(raw, np.uint8) % LINE
    found = []
    for count in counts:
        found.append(np.ndarray((count + slack,), dtype, raw, skip))
        skip += (count + slack - 1) // slack * LINE + LINE
    return found
