# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Whether the content of an array is what it was, without a copy of it."""

import numpy as np

from libc.stdint cimport uint64_t
from libc.string cimport memcpy, memset

from arael.runtime.address cimport address

# Odd, with about as many ones as zeros: the golden ratio as a fraction of 2^64.
cdef uint64_t FACTOR = <uint64_t>0x9E3779B97F4A7C15


cdef inline uint64_t mixed(uint64_t state, uint64_t word) noexcept nogil:
    """One to one in `word` and in `state`: a single change can never be lost."""
    state = (state ^ word) * FACTOR
    return state ^ (state >> 32)


def fingerprint(array):
    """Four numbers that differ when shape, type or content of the array do.

    256 bits, not made against an adversary: they tell whether data that a program may have written
    through a view has changed since a solve.
    """
    cdef const unsigned char* data
    cdef uint64_t a = 1, b = 2, c = 3, d = 4
    cdef uint64_t words[4]
    cdef Py_ssize_t size, at
    if not array.flags.c_contiguous:
        array = np.ascontiguousarray(array)
    data = <const unsigned char*>address(array, array.dtype)
    size = array.nbytes
    with nogil:
        for at in range(0, size - 31, 32):
            memcpy(words, data + at, 32)
            a, b = mixed(a, words[0]), mixed(b, words[1])
            c, d = mixed(c, words[2]), mixed(d, words[3])
        at = size - size % 32
        memset(words, 0, 32)
        memcpy(words, data + at, size - at)
        a, b = mixed(a, words[0]), mixed(b, words[1])
        c, d = mixed(c, words[2]), mixed(d, words[3])
    return a, b, c, d, array.shape, array.dtype.char
