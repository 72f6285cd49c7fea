"""The arrays of J'r and J'J, with what lies behind them: trash, and places of the shares' own."""

import numpy as np

from libc.stdint cimport int64_t
from libc.string cimport memset

from cython cimport floating

from arael.runtime.address cimport address, table_address
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
        self.gradient_extent, self.value_extent = plan.gradient_extent, plan.value_extent
        self._keep = []
        self._all = (plan.cleared, plan.cleared_ends, held, held_values)
        self.diagonal_at = self._kept(diagonal_at)
        self._gradient_sums = self._kept(plan.gradient_sums)
        self._value_sums = self._kept(plan.value_sums)
        self._gradient_ends = self._kept(ends_of(plan.gradient_sums, plan.count))
        self._value_ends = self._kept(ends_of(plan.value_sums, plan.count))
        self.restrict()

    cdef const int64_t* _kept(self, array) except? NULL:
        """The array as memory that lives as long as this object."""
        kept = np.ascontiguousarray(array, dtype=np.int64)
        self._keep.append(kept)
        return <const int64_t*>address(kept, np.int64)

    def hold_others(self, held, held_values):
        """Let other scalars be those that do not move; parameters as those of the class."""
        self._all = (*self._all[:2], held, held_values)
        self.restrict()

    def restrict(self, gradient=None, values=None):
        """Zero some scalars and values only; other contributions add up to what is not defined.

        Parameters
        ----------
        gradient, values : (m, 2) int64, or None
            Begin and end of what is zeroed, as far as it was zeroed before; None: all of it.
        """
        cleared, cleared_ends, held, held_values = self._all
        self._some, self._some_count = NULL, 0
        if gradient is not None:
            # What is stored first may be zeroed as well.
            cleared = values
            cleared_ends = np.arange(len(self._all[1])) * len(values) // (len(self._all[1]) - 1)
            held = held[within(held, gradient)]
            held_values = held_values[within(held_values, values)]
        self._chosen = [
            np.ascontiguousarray(array, dtype=np.int64)
            for array in (cleared, cleared_ends, held, held_values, gradient)
            if array is not None
        ]
        self._cleared = <const int64_t*>address(self._chosen[0], np.int64)
        self._cleared_ends = <const int64_t*>address(self._chosen[1], np.int64)
        self._held, self._held_count = <const int64_t*>address(self._chosen[2], np.int64), len(held)
        self._held_values = <const int64_t*>address(self._chosen[3], np.int64)
        self._held_value_count = len(held_values)
        if gradient is not None:
            self._some = <const int64_t*>table_address(self._chosen[4], 2)
            self._some_count = len(gradient)

    cdef void clear(
        self, Py_ssize_t part, Py_ssize_t parts, void* gradient, void* values
    ) noexcept nogil:
        cdef Py_ssize_t item = 4 if self.single else 8, k
        if self._some == NULL:
            clear_lines(<char*>gradient, self.gradient_extent * item, part, parts)
        for k in range(self._some_count * part // parts, self._some_count * (part + 1) // parts):
            memset(<char*>gradient + self._some[2 * k] * item, 0,
                   (self._some[2 * k + 1] - self._some[2 * k]) * item)
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
            np.frombuffer(bytes_at(gradient, self.gradient_extent * item), dtype),
            np.frombuffer(bytes_at(values, self.value_extent * item), dtype),
        )

    def kept(self):
        """Arrays like those of `zeros`, the same for all solves; what is in them is left over."""
        # The first touch of fresh memory takes as long as a linearisation.
        if self._arrays is None:
            self._arrays = self.zeros()
        return self._arrays

    def take_arrays(self, Totals other):
        """Have the kept arrays of `other`, which is used no more, if they are of the same size."""
        if (self.single == other.single and self.gradient_extent == other.gradient_extent
                and self.value_extent == other.value_extent):
            self._arrays = other._arrays

    def zeros(self):
        """Zeroed arrays for J'r and the values of J'J, with trash cells and copies behind them."""
        dtype = np.float32 if self.single else np.float64
        return np.zeros(self.gradient_extent, dtype), np.zeros(self.value_extent, dtype)


def within(at, runs):
    """Which places lie in runs (begin, end) that are in ascending order."""
    found = np.searchsorted(runs[:, 0], at, side="right") - 1
    return (found >= 0) & (at < np.append(runs[:, 1], 0)[found])


def ends_of(sums, count):
    """Rows at which equal parts of the sums begin and end, those of one target together."""
    if not len(sums):
        return np.zeros(count + 1, dtype=np.int64)
    ends = np.arange(count + 1) * len(sums) // count
    first = np.flatnonzero(np.diff(sums[:, 0], prepend=-1))
    ends = np.append(first, len(sums))[np.searchsorted(first, ends)]
    ends[0] = 0
    return ends
