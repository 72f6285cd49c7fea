# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Rows in which flags hold, and the scalars of these rows, in one pass each."""

import numpy as np

from libc.stdint cimport uint8_t

from arael.runtime.address cimport address, writable


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
