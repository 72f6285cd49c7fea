# cython: language_level=3, boundscheck=False, cdivision=True
"""Block elimination of an independent set: the Schur complement and what is needed to go back.

With the eliminated entities first, ``[D W; W' K] [x; y] = [a; b]``. D is block diagonal; with its
Cholesky factor L and ``Z = L^-1 W`` the reduced system is ``(K - Z'Z) y = b - Z' L^-1 a``, and
``x = L^-T (L^-1 a - Z y)``. After D. C. Brown, "The bundle adjustment - progress and prospects",
Int. Archives of Photogrammetry 21 (1976), as in Triggs et al., "Bundle adjustment - a modern
synthesis" (2000), section 6.
"""

import numpy as np

from libc.string cimport memcpy, memset

from arael.runtime.linear cimport eliminate as kernels
from arael.runtime.linear.blas cimport real
from arael.runtime.linear.blocks cimport address
from arael.runtime.linear.eliminate cimport Block, Coupling, Entity

from arael.runtime.linear.eliminate import SLACK
from arael.runtime.linear.memory import aligned


cdef class Elimination:
    """Storage of the eliminated entities, and the passes over them.

    Parameters
    ----------
    reduction : Reduction
    dtype : NumPy type
    """

    def __init__(self, reduction, dtype):
        self.reduction = reduction
        self.n = len(reduction.scalars)
        factors = aligned(reduction.factor_size, dtype)
        stored = aligned(reduction.stored_size, dtype)
        eliminated = aligned(reduction.pattern.size, dtype)
        largest = int(reduction.entities["size"].max(initial=1))
        work = aligned(largest, dtype)
        before = aligned(reduction.padded_size, dtype)
        after = aligned(reduction.padded_size, dtype)
        # Blocks of couplings are fetched ahead of their turn.
        ahead = np.zeros(SLACK, reduction.couplings.dtype)
        couplings = np.append(reduction.couplings, ahead)
        scalars, padded = np.append(reduction.scalars, 0), np.append(reduction.padded, 0)
        self._keep = (factors, stored, eliminated, work, before, after, couplings, scalars, padded)
        self._count = len(reduction.entities) - 1
        self._entities = <const Entity*>address(reduction.entities)
        self._couplings = <const Coupling*>address(couplings)
        self._scalar = <const long long*>address(scalars)
        self._padded = <const long long*>address(padded)
        self._padded_size = reduction.padded_size
        self._factors, self._stored = address(factors), address(stored)
        self._eliminated, self._work = address(eliminated), address(work)
        self._input, self._output = address(before), address(after)

    cdef Py_ssize_t eliminate(self, const real* values, const real* diagonal) noexcept nogil:
        return kernels.eliminate(self._count, self._entities, self._couplings, values, diagonal,
                                 <real*>self._factors, <real*>self._stored)

    cdef void descend(self, const real* b, real* reduced) noexcept nogil:
        cdef Py_ssize_t i
        cdef real* y = <real*>self._output
        for i in range(self.n):
            y[self._padded[i]] = b[self._scalar[i]]
        kernels.descend(self._count, self._entities, self._couplings, <const real*>self._factors,
                        <const real*>self._stored, b, <real*>self._eliminated, y)
        for i in range(self.n):
            reduced[i] = y[self._padded[i]]

    cdef void ascend(self, const real* reduced, real* x) noexcept nogil:
        cdef Py_ssize_t i
        cdef real* y = <real*>self._input
        for i in range(self.n):
            y[self._padded[i]] = reduced[i]
            x[self._scalar[i]] = reduced[i]
        kernels.ascend(self._count, self._entities, self._couplings, <const real*>self._factors,
                       <const real*>self._stored, y, <real*>self._eliminated, x)

    cdef void multiply(
        self, Py_ssize_t count, const Block* blocks, const real* values, bint whole, const real* x,
        real* y
    ) noexcept nogil:
        cdef Py_ssize_t i
        cdef real* before = <real*>self._input
        cdef real* after = <real*>self._output
        memset(after, 0, self._padded_size * sizeof(real))
        for i in range(self.n):
            before[self._padded[i]] = x[i]
        kernels.symmetric(count, blocks, values, before, after)
        if not whole:
            kernels.apply(self._count, self._entities, self._couplings, <const real*>self._stored,
                          before, <real*>self._work, after)
        for i in range(self.n):
            y[i] = after[self._padded[i]]


cdef class Sums:
    """Blocks of the reduced system, or of a part of it.

    Parameters
    ----------
    of : Elimination
    products : Products
    dtype : NumPy type
    """

    def __init__(self, Elimination of, products, dtype):
        pattern = products.pattern
        columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
        height, width = pattern.sizes[pattern.rows], pattern.sizes[columns]
        copies = np.stack((pattern.value_start, products.sources[:-1], height * width), axis=1)
        copies = np.ascontiguousarray(copies, dtype=np.int64)
        own = pattern.value_start[pattern.column_start[:-1]]
        sizes = pattern.sizes
        local = np.arange(of.n) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        diagonal = np.repeat(own, sizes) + local * (np.repeat(sizes, sizes) + 1)
        diagonal = np.append(diagonal, 0).astype(np.int64)
        values, damped = aligned(pattern.value_count, dtype), aligned(of.n, dtype)
        self.products, self._of = products, of
        self._keep = (copies, diagonal, values, damped)
        self._count, self._blocks = len(products.tasks), len(copies)
        self._tasks = <const long long*>address(products.tasks)
        self._pairs = <const int*>address(products.pairs)
        self._copies = <const long long*>address(copies)
        self._diagonal = <const long long*>address(diagonal)
        self._values, self._damped = address(values), address(damped)

    cdef void form(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t k
        cdef const long long* copy = self._copies
        cdef const long long* task = self._tasks
        cdef real* to = <real*>self._values
        cdef real* damped = <real*>self._damped
        for _ in range(self._blocks):
            if copy[1] >= 0:
                memcpy(to + copy[0], values + copy[1], copy[2] * sizeof(real))
            else:
                memset(to + copy[0], 0, copy[2] * sizeof(real))
            copy += 3
        for k in range(self._of.n):
            to[self._diagonal[k]] = diagonal[self._of._scalar[k]]
        for _ in range(self._count):
            kernels.gram(<int>task[3], <int>task[1], <int>task[2], task[5],
                         self._pairs + 2 * task[4], <const real*>self._of._stored, to + task[0])
            task += 6
        for k in range(self._of.n):
            damped[k] = to[self._diagonal[k]]
