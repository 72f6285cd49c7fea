"""Block elimination of an independent set: Schur complement and back substitution.

With the eliminated entities first, ``[D W; W' K] [x; y] = [a; b]``. D is block diagonal; with its
Cholesky factor L and ``Z = L^-1 W`` the reduced system is ``(K - Z'Z) y = b - Z' L^-1 a``, and
``x = L^-T (L^-1 a - Z y)``. After D. C. Brown, "The bundle adjustment - progress and prospects",
Int. Archives of Photogrammetry 21 (1976), as in Triggs et al., "Bundle adjustment - a modern
synthesis" (2000), section 6.
"""

import numpy as np

cimport cython

from libc.string cimport memcpy, memset

from arael.runtime.address cimport address, table_address, writable
from arael.runtime.parallel.compiled cimport distribute

from arael.runtime.compiled import aligned_zeros
from arael.runtime.linear import parts

# Entities that are swept directly after their elimination: a fraction of a second-level cache.
cdef enum:
    TOGETHER = 128


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
        factors = aligned_zeros(reduction.factor_size, dtype)
        stored = aligned_zeros(reduction.stored_size, dtype)
        eliminated = aligned_zeros(reduction.pattern.size, dtype)
        largest = int(reduction.entities["size"].max(initial=1))
        cost = parts.entity_costs(reduction)
        part_ends = parts.split(cost, parts.count(cost.sum()))
        sweep_ends = parts.split(cost, parts.sweeps(reduction, cost.sum()))
        tails = _tails(reduction, sweep_ends)
        failed = np.zeros(len(part_ends), dtype=np.int64)
        outputs = aligned_zeros((len(sweep_ends) - 2) * reduction.padded_size, dtype)
        self._work_stride = -(-largest // 16) * 16
        work = aligned_zeros((len(sweep_ends) - 1) * self._work_stride, dtype)
        before = aligned_zeros(reduction.padded_size, dtype)
        after = aligned_zeros(reduction.padded_size, dtype)
        # Blocks of couplings are prefetched.
        ahead = np.zeros(SLACK, reduction.couplings.dtype)
        couplings = np.append(reduction.couplings, ahead)
        scalars, padded = np.append(reduction.scalars, 0), np.append(reduction.padded, 0)
        self._keep = (factors, stored, eliminated, work, before, after, couplings, scalars, padded,
                      part_ends, sweep_ends, tails, failed, outputs)
        self.threads = 1
        self.single = np.dtype(dtype) == np.float32
        self._parts, self._sweeps = len(part_ends) - 1, len(sweep_ends) - 1
        # Fewer sweeps than threads would delay the elimination.
        self._together = self._sweeps >= min(self._parts, parts.SWEEPS)
        self._part_ends = <const long long*>address(part_ends, np.int64)
        self._sweep_ends = <const long long*>address(sweep_ends, np.int64)
        self._tails = <const long long*>address(tails, np.int64)
        self._failed = <long long*>writable(failed, np.int64)
        self._outputs = writable(outputs, dtype)
        self._count = len(reduction.entities) - 1
        self._entities = <const Entity*>address(reduction.entities, ENTITY)
        self._couplings = <const Coupling*>address(couplings, COUPLING)
        self._scalar = <const long long*>address(scalars, np.int64)
        self._padded = <const long long*>address(padded, np.int64)
        self._padded_size = reduction.padded_size
        self._factors, self._stored = writable(factors, dtype), writable(stored, dtype)
        self._eliminated, self._work = writable(eliminated, dtype), writable(work, dtype)
        self._input, self._output = writable(before, dtype), writable(after, dtype)

    cdef Py_ssize_t eliminate(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Pass job
        job.of, job.values, job.diagonal = <void*>self, values, diagonal
        distribute(self.threads, self._parts, eliminate_part, &job)
        return self._first_failure(self._parts)

    cdef Py_ssize_t eliminate_with(
        self, const real* values, const real* diagonal, const real* b, real* reduced
    ) noexcept nogil:
        cdef Pass job
        cdef Py_ssize_t failed, k
        if not self._together:
            failed = self.eliminate(values, diagonal)
            if failed == 0:
                self.descend(b, reduced)
            return failed
        self._put_kept(b)
        job.of, job.values, job.diagonal, job.b = <void*>self, values, diagonal, b
        distribute(self.threads, self._sweeps, eliminate_with_part, &job)
        failed = self._first_failure(self._sweeps)
        if failed == 0:
            for k in range(self._sweeps):
                self._sweep(self._tails[k], self._sweep_ends[k + 1], b, self._place_of(k, b))
            self._take_kept(reduced)
        return failed

    cdef void descend(self, const real* b, real* reduced) noexcept nogil:
        cdef Pass job
        self._put_kept(b)
        job.of, job.values = <void*>self, b
        distribute(self.threads, self._sweeps, descend_part, &job)
        self._take_kept(reduced)

    cdef Py_ssize_t _first_failure(self, Py_ssize_t count) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(count):
            if self._failed[k]:
                return self._failed[k]
        return 0

    cdef void _put_kept(self, const real* b) noexcept nogil:
        """Initialise a sweep with the kept entities of `b`."""
        cdef Py_ssize_t i
        cdef real* y = <real*>self._output
        for i in range(self.n):
            y[self._padded[i]] = b[self._scalar[i]]

    cdef void _take_kept(self, real* reduced) noexcept nogil:
        """Combine the results of all parts of a sweep."""
        cdef Py_ssize_t i
        cdef real* y = <real*>self._output
        self._add_outputs(y)
        for i in range(self.n):
            reduced[i] = y[self._padded[i]]

    cdef void ascend(self, const real* reduced, real* x) noexcept nogil:
        cdef Pass job
        cdef Py_ssize_t i
        cdef real* y = <real*>self._input
        for i in range(self.n):
            y[self._padded[i]] = reduced[i]
            x[self._scalar[i]] = reduced[i]
        job.of, job.out = <void*>self, x
        distribute(self.threads, self._parts, ascend_part, &job)

    cdef void multiply(
        self, Py_ssize_t count, const Block* blocks, const real* values, bint whole, const real* x,
        real* y
    ) noexcept nogil:
        cdef Pass job
        cdef Py_ssize_t i
        cdef real* before = <real*>self._input
        cdef real* after = <real*>self._output
        memset(after, 0, self._padded_size * sizeof(real))
        for i in range(self.n):
            before[self._padded[i]] = x[i]
        block_symmetric(count, blocks, values, before, after)
        if not whole:
            job.of = <void*>self
            distribute(self.threads, self._sweeps, apply_part, &job)
            self._add_outputs(after)
        for i in range(self.n):
            y[i] = after[self._padded[i]]

    cdef void _add_outputs(self, real* y) noexcept nogil:
        """Add the vectors of the parts of a sweep, in order."""
        cdef Py_ssize_t i
        cdef const real* part = <const real*>self._outputs
        for _ in range(self._sweeps - 1):
            for i in range(self._padded_size):
                y[i] += part[i]
            part += self._padded_size

    cdef void _eliminate_part(
        self, Py_ssize_t k, const real* values, const real* diagonal
    ) noexcept nogil:
        cdef Py_ssize_t begin = self._part_ends[k], end = self._part_ends[k + 1]
        self._failed[k] = block_eliminate(
            end - begin, self._entities + begin, self._couplings, values, diagonal,
            <real*>self._factors, <real*>self._stored)

    cdef void _eliminate_with_part(
        self, Py_ssize_t k, const real* values, const real* diagonal, const real* b
    ) noexcept nogil:
        cdef Py_ssize_t begin = self._sweep_ends[k], end = self._sweep_ends[k + 1], count
        cdef Py_ssize_t tail = self._tails[k]
        cdef real* output = self._output_of(k, b)
        self._failed[k] = 0
        while begin < end and self._failed[k] == 0:
            count = min(TOGETHER, end - begin)
            self._failed[k] = block_eliminate(
                count, self._entities + begin, self._couplings, values, diagonal,
                <real*>self._factors, <real*>self._stored)
            if self._failed[k] == 0:
                self._sweep(begin, min(begin + count, tail), b, output)
            begin += count

    cdef void _descend_part(self, Py_ssize_t k, const real* b) noexcept nogil:
        self._sweep(self._sweep_ends[k], self._sweep_ends[k + 1], b, self._output_of(k, b))

    cdef void _sweep(
        self, Py_ssize_t begin, Py_ssize_t end, const real* b, real* output
    ) noexcept nogil:
        if begin < end:
            block_descend(end - begin, self._entities + begin, self._couplings,
                          <const real*>self._factors, <const real*>self._stored, b,
                          <real*>self._eliminated, output)

    cdef void _ascend_part(self, Py_ssize_t k, real* x) noexcept nogil:
        cdef Py_ssize_t begin = self._part_ends[k], end = self._part_ends[k + 1]
        block_ascend(end - begin, self._entities + begin, self._couplings,
                     <const real*>self._factors, <const real*>self._stored,
                     <const real*>self._input, <real*>self._eliminated, x)

    cdef void _apply_part(self, Py_ssize_t k, const real* _) noexcept nogil:
        cdef Py_ssize_t begin = self._sweep_ends[k], end = self._sweep_ends[k + 1]
        block_apply(end - begin, self._entities + begin, self._couplings,
                    <const real*>self._stored, <const real*>self._input,
                    <real*>self._work + k * self._work_stride, self._output_of(k, _))

    cdef real* _output_of(self, Py_ssize_t k, const real* _) noexcept nogil:
        """Output vector of part k of a sweep: the output itself for the first, else zeros."""
        cdef real* y = self._place_of(k, _)
        if k > 0:
            memset(y, 0, self._padded_size * sizeof(real))
        return y

    cdef real* _place_of(self, Py_ssize_t k, const real* _) noexcept nogil:
        if k == 0:
            return <real*>self._output
        return <real*>self._outputs + (k - 1) * self._padded_size


@cython.wraparound(True)
def _tails(reduction, ends):
    """First entity of each part whose sweep would read data that the next part stores.

    Kernels read whole vectors, though they use only the entries of a row.
    """
    behind = np.append(reduction.couplings["place"], reduction.stored_size)
    behind = behind[reduction.entities["couplings"][1:]]
    first = np.searchsorted(behind, behind[ends[1:-1] - 1] - PADDING, side="right")
    return np.append(np.clip(first, ends[:-2], ends[1:-1]), ends[-1]).astype(np.int64)


cdef void eliminate_part(void* job, Py_ssize_t k) noexcept nogil:
    cdef Pass* p = <Pass*>job
    if (<Elimination>p.of).single:
        (<Elimination>p.of)._eliminate_part(k, <const float*>p.values, <const float*>p.diagonal)
    else:
        (<Elimination>p.of)._eliminate_part(k, <const double*>p.values, <const double*>p.diagonal)


cdef void eliminate_with_part(void* job, Py_ssize_t k) noexcept nogil:
    cdef Pass* p = <Pass*>job
    if (<Elimination>p.of).single:
        (<Elimination>p.of)._eliminate_with_part(
            k, <const float*>p.values, <const float*>p.diagonal, <const float*>p.b)
    else:
        (<Elimination>p.of)._eliminate_with_part(
            k, <const double*>p.values, <const double*>p.diagonal, <const double*>p.b)


cdef void descend_part(void* job, Py_ssize_t k) noexcept nogil:
    cdef Pass* p = <Pass*>job
    if (<Elimination>p.of).single:
        (<Elimination>p.of)._descend_part(k, <const float*>p.values)
    else:
        (<Elimination>p.of)._descend_part(k, <const double*>p.values)


cdef void ascend_part(void* job, Py_ssize_t k) noexcept nogil:
    cdef Pass* p = <Pass*>job
    if (<Elimination>p.of).single:
        (<Elimination>p.of)._ascend_part(k, <float*>p.out)
    else:
        (<Elimination>p.of)._ascend_part(k, <double*>p.out)


cdef void apply_part(void* job, Py_ssize_t k) noexcept nogil:
    cdef Pass* p = <Pass*>job
    if (<Elimination>p.of).single:
        (<Elimination>p.of)._apply_part(k, <const float*>NULL)
    else:
        (<Elimination>p.of)._apply_part(k, <const double*>NULL)


cdef void form_part(void* job, Py_ssize_t k) noexcept nogil:
    cdef Pass* p = <Pass*>job
    if (<Sums>p.of)._of.single:
        (<Sums>p.of)._form_part(k, <const float*>p.values, <const float*>p.diagonal)
    else:
        (<Sums>p.of)._form_part(k, <const double*>p.values, <const double*>p.diagonal)


cdef class Sums:
    """Blocks of the reduced system, or of a part of it.

    Parameters
    ----------
    of : Elimination
    products : Products
    dtype : NumPy type
    """

    @cython.wraparound(True)
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
        values, damped = aligned_zeros(pattern.value_count, dtype), aligned_zeros(of.n, dtype)
        self.products, self._of = products, of
        ends = parts.split_columns(products)
        self._keep = (copies, diagonal, values, damped, ends)
        self._parts = len(ends) - 1
        self._part_ends = <const long long*>address(ends, np.int64)
        self._tasks = <const long long*>table_address(products.tasks, 6)
        self._pairs = <const int*>address(products.pairs, np.int32)
        self._copies = <const long long*>table_address(copies, 3)
        self._diagonal = <const long long*>address(diagonal, np.int64)
        self._values, self._damped = writable(values, dtype), writable(damped, dtype)

    cdef void form(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Pass job
        job.of, job.values, job.diagonal = <void*>self, values, diagonal
        distribute(self._of.threads, self._parts, form_part, &job)

    cdef void _form_part(
        self, Py_ssize_t k, const real* values, const real* diagonal
    ) noexcept nogil:
        cdef const long long* begin = self._part_ends + 3 * k
        cdef const long long* end = begin + 3
        cdef const long long* copy = self._copies + 3 * begin[0]
        cdef const long long* task = self._tasks + 6 * begin[2]
        cdef Py_ssize_t i
        cdef real* to = <real*>self._values
        cdef real* damped = <real*>self._damped
        for _ in range(end[0] - begin[0]):
            if copy[1] >= 0:
                memcpy(to + copy[0], values + copy[1], copy[2] * sizeof(real))
            else:
                memset(to + copy[0], 0, copy[2] * sizeof(real))
            copy += 3
        for i in range(begin[1], end[1]):
            to[self._diagonal[i]] = diagonal[self._of._scalar[i]]
        for _ in range(end[2] - begin[2]):
            block_gram(<int>task[3], <int>task[1], <int>task[2], task[5],
                       self._pairs + 2 * task[4], <const real*>self._of._stored, to + task[0])
            task += 6
        for i in range(begin[1], end[1]):
            damped[i] = to[self._diagonal[i]]
