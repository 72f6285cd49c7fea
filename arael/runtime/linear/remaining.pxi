"""A solver for some of the independent parts of a system, in the place of one for the whole."""

from libc.stdint cimport int64_t
from libc.string cimport memcpy

from arael.runtime.address cimport table_address, writable

from arael.runtime.compiled import aligned_zeros


cdef void gather(
    const int64_t* runs, Py_ssize_t count, Py_ssize_t item, const char* whole, char* part
) noexcept nogil:
    """Copy runs (whole, part, length) of scalars of `item` bytes to the part."""
    cdef Py_ssize_t k
    for k in range(count):
        memcpy(part + runs[3 * k + 1] * item, whole + runs[3 * k] * item, runs[3 * k + 2] * item)


cdef class RemainingSolver(LinearSolver):
    """Solves for the scalars that remain; of solutions, the others stay as they are.

    Has the interface of a solver for the whole system: values, diagonal and right-hand side are
    those of the whole, and so is the scalar at which a factorisation fails.

    Parameters
    ----------
    pattern : BlockPattern
        The whole.
    inner : LinearSolver
        Solver for what remains, in the same precision.
    scalars, values : (m, 3) int64
        Runs of scalars, and of values, that remain: where each begins in the whole and in the
        inner solver's arrays, and its length.
    """

    cdef readonly LinearSolver inner
    cdef object _keep
    cdef const int64_t* _scalars
    cdef const int64_t* _values
    cdef Py_ssize_t _scalar_count
    cdef Py_ssize_t _value_count
    cdef Py_ssize_t _item
    cdef char* _own_values
    cdef char* _own_diagonal
    cdef char* _own_vector

    def __init__(self, pattern, LinearSolver inner, scalars, values):
        super().__init__(pattern, inner.single)
        self.inner, self.threads = inner, inner.threads
        self.raised, self.plan = inner.raised, inner.plan
        dtype = self.dtype
        arrays = [aligned_zeros(n, dtype) for n in (inner.pattern.value_count, inner.n, inner.n)]
        self._keep = (scalars, values, arrays)
        self._scalars = <const int64_t*>table_address(scalars, 3)
        self._values = <const int64_t*>table_address(values, 3)
        self._scalar_count, self._value_count = len(scalars), len(values)
        self._item = dtype.itemsize
        self._own_values = <char*>writable(arrays[0], dtype)
        self._own_diagonal = <char*>writable(arrays[1], dtype)
        self._own_vector = <char*>writable(arrays[2], dtype)

    def use_threads(self, int threads):
        """Set the number of threads of the inner solver."""
        self.threads = threads
        self.inner.use_threads(threads)

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        self._take(values, diagonal)
        return self._named(self.inner.factor(self._own_values, self._own_diagonal))

    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b
    ) noexcept nogil:
        self._take(values, diagonal)
        self._take_vector(b)
        return self._named(
            self.inner.factor_with(self._own_values, self._own_diagonal, self._own_vector))

    cdef void solve(self, void* b) noexcept nogil:
        self._take_vector(b)
        self.inner.solve(self._own_vector)
        self._give_vector(b)

    cdef void finish(self, void* b) noexcept nogil:
        self.inner.finish(self._own_vector)
        self._give_vector(b)

    cdef void _take(self, const void* values, const void* diagonal) noexcept nogil:
        gather(self._values, self._value_count, self._item, <const char*>values, self._own_values)
        gather(self._scalars, self._scalar_count, self._item, <const char*>diagonal,
               self._own_diagonal)

    cdef void _take_vector(self, const void* b) noexcept nogil:
        gather(self._scalars, self._scalar_count, self._item, <const char*>b, self._own_vector)

    cdef void _give_vector(self, void* b) noexcept nogil:
        cdef Py_ssize_t k
        cdef const int64_t* run
        for k in range(self._scalar_count):
            run = self._scalars + 3 * k
            memcpy(<char*>b + run[0] * self._item, self._own_vector + run[1] * self._item,
                   run[2] * self._item)

    cdef Py_ssize_t _named(self, Py_ssize_t status) noexcept nogil:
        """Status of the inner solver in scalars of the whole system."""
        cdef Py_ssize_t low = 0, high = self._scalar_count, middle
        cdef const int64_t* run
        if status == 0:
            return 0
        # The last run that does not begin behind the scalar.
        while high - low > 1:
            middle = (low + high) // 2
            if self._scalars[3 * middle + 1] <= status - 1:
                low = middle
            else:
                high = middle
        run = self._scalars + 3 * low
        return status - run[1] + run[0]
