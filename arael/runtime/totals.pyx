# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The arrays of J'r and J'J, with what lies behind them: trash, and places of the shares' own."""

import numpy as np

from libc.stdint cimport int64_t
from libc.string cimport memset

from cython cimport floating

from arael.runtime.address cimport address
from arael.runtime.raw cimport bytes_at


cdef void clear_lines(
    char* memory, Py_ssize_t size, Py_ssize_t part, Py_ssize_t parts
) noexcept nogil:
    """Zero one of several parts of some bytes, cut at cache lines."""
    cdef Py_ssize_t lines = (size + 63) // 64
    cdef Py_ssize_t begin = min(size, lines * part // parts * 64)
    cdef Py_ssize_t end = min(size, lines * (part + 1) // parts * 64)
    memset(memory + begin, 0, end - begin)


cdef void add_places(
    const int64_t* sums, Py_ssize_t begin, Py_ssize_t end, floating* x
) noexcept nogil:
    """Add from source to target in some rows of (target, source, count), and empty the sources."""
    cdef Py_ssize_t k, i
    cdef floating *target
    cdef floating *source
    for k in range(begin, end):
        target, source = x + sums[3 * k], x + sums[3 * k + 1]
        for i in range(sums[3 * k + 2]):
            target[i] += source[i]
            source[i] = 0


cdef class Totals:
    """What is done to the arrays before and after contributions are added to them.

    Parameters
    ----------
    plan : Shares
    held : (m,) scalars of the system that do not move
    held_values, diagonal_at : int64 arrays, offsets in the values
    single : bool
    """

    def __init__(self, plan, held, held_values, diagonal_at, bint single):
        self.single = single
        self.gradient_room, self.value_room = plan.gradient_room, plan.value_room
        self._keep = []
        self.diagonal_at = self._kept(diagonal_at)
        self._gradient_sums = self._kept(plan.gradient_sums)
        self._value_sums = self._kept(plan.value_sums)
        self._cleared = self._kept(plan.cleared)
        self._cleared_ends = self._kept(plan.cleared_ends)
        self._gradient_ends = self._kept(ends_of(plan.gradient_sums, plan.count))
        self._value_ends = self._kept(ends_of(plan.value_sums, plan.count))
        self._held, self._held_count = self._kept(held), len(held)
        self._held_values, self._held_value_count = self._kept(held_values), len(held_values)

    cdef const int64_t* _kept(self, array) except? NULL:
        """The array as memory that lives as long as this object."""
        kept = np.ascontiguousarray(array, dtype=np.int64)
        self._keep.append(kept)
        return <const int64_t*>address(kept, np.int64)

    cdef void clear(
        self, Py_ssize_t part, Py_ssize_t parts, void* gradient, void* values
    ) noexcept nogil:
        cdef Py_ssize_t item = 4 if self.single else 8, k
        clear_lines(<char*>gradient, self.gradient_room * item, part, parts)
        for k in range(self._cleared_ends[part], self._cleared_ends[part + 1]):
            memset(<char*>values + self._cleared[2 * k] * item, 0,
                   (self._cleared[2 * k + 1] - self._cleared[2 * k]) * item)

    cdef void add(self, Py_ssize_t share, void* gradient, void* values) noexcept nogil:
        cdef const int64_t* g = self._gradient_ends + share
        cdef const int64_t* v = self._value_ends + share
        if self.single:
            add_places(self._gradient_sums, g[0], g[1], <float*>gradient)
            add_places(self._value_sums, v[0], v[1], <float*>values)
        else:
            add_places(self._gradient_sums, g[0], g[1], <double*>gradient)
            add_places(self._value_sums, v[0], v[1], <double*>values)

    cdef void hold(self, void* gradient, void* values) noexcept nogil:
        if self.single:
            self._hold(<float*>gradient, <float*>values)
        else:
            self._hold(<double*>gradient, <double*>values)

    cdef void _hold(self, floating* gradient, floating* values) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self._held_value_count):
            values[self._held_values[k]] = 0
        for k in range(self._held_count):
            values[self.diagonal_at[self._held[k]]] = 1
            gradient[self._held[k]] = 0

    cdef views(self, void* gradient, void* values):
        dtype = np.dtype(np.float32 if self.single else np.float64)
        cdef Py_ssize_t item = dtype.itemsize
        return (
            np.frombuffer(bytes_at(gradient, self.gradient_room * item), dtype),
            np.frombuffer(bytes_at(values, self.value_room * item), dtype),
        )

    def kept(self):
        """Arrays like those of `zeros`, the same for all solves; what is in them is left over."""
        # The first touch of fresh memory takes as long as a linearisation.
        if self._arrays is None:
            self._arrays = self.zeros()
        return self._arrays

    def zeros(self):
        """Zeroed arrays for J'r and the values of J'J, with trash cells and copies behind them."""
        dtype = np.float32 if self.single else np.float64
        return np.zeros(self.gradient_room, dtype), np.zeros(self.value_room, dtype)


def ends_of(sums, count):
    """Rows at which equal parts of the sums begin and end, those of one target together."""
    if not len(sums):
        return np.zeros(count + 1, dtype=np.int64)
    ends = np.arange(count + 1) * len(sums) // count
    first = np.flatnonzero(np.diff(sums[:, 0], prepend=-1))
    ends = np.append(first, len(sums))[np.searchsorted(first, ends)]
    ends[0] = 0
    return ends
