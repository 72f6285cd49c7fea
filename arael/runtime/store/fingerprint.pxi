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


cdef void mix(uint64_t* sums, const unsigned char* data, Py_ssize_t size) noexcept nogil:
    """Take the bytes of an array into four sums."""
    # Variables of their own, which stay in registers: bytes may be those of `sums`.
    cdef uint64_t a = sums[0], b = sums[1], c = sums[2], d = sums[3]
    cdef uint64_t words[4]
    cdef Py_ssize_t at
    for at in range(0, size - 31, 32):
        memcpy(words, data + at, 32)
        a, b = mixed(a, words[0]), mixed(b, words[1])
        c, d = mixed(c, words[2]), mixed(d, words[3])
    at = size - size % 32
    memset(words, 0, 32)
    memcpy(words, data + at, size - at)
    sums[0], sums[1] = mixed(a, words[0]), mixed(b, words[1])
    sums[2], sums[3] = mixed(c, words[2]), mixed(d, words[3])


def fingerprint(array):
    """Four numbers that differ when shape, type or content of the array do.

    256 bits, not made against an adversary: they tell whether data that a program may have written
    through a view has changed since a solve.
    """
    cdef uint64_t[4] sums = [1, 2, 3, 4]
    if not array.flags.c_contiguous:
        array = np.ascontiguousarray(array)
    cdef const unsigned char* data = <const unsigned char*>address(array, array.dtype)
    cdef Py_ssize_t size = array.nbytes
    with nogil:
        mix(sums, data, size)
    return sums[0], sums[1], sums[2], sums[3], array.shape, array.dtype.char


def fingerprints(list arrays):
    """List of the `fingerprint` of each array."""
    return [fingerprint(array) for array in arrays]


def fingerprint_of_flags(list arrays):
    """Four numbers that differ when the length or the content of some contiguous array does.

    Parameters
    ----------
    arrays : bool arrays, C order, the same ones in the same order each time
    """
    cdef uint64_t[4] sums = [1, 2, 3, 4]
    cdef const unsigned char* data
    cdef Py_ssize_t size
    for array in arrays:
        data, size = <const unsigned char*>address(array, np.bool_), array.nbytes
        mix(sums, <const unsigned char*>&size, sizeof(size))
        mix(sums, data, size)
    return sums[0], sums[1], sums[2], sums[3]
