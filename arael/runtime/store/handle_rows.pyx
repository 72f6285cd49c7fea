# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Rows that handles stand for, in one pass; see `slots.py` for what a handle is."""

import numpy as np

from libc.stdint cimport int64_t

from arael.runtime.address cimport address, writable


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
