"""A problem whose constraints are evaluated, and whose system is solved, somewhere else.

The loop (`loop.pxi`) holds the states and the vectors of the whole problem. Cost, gradient,
diagonal and curvature are sums over parts, and a step is the solution of a system in parts; each is
asked of one Python object, once an attempt. So a problem in parts is solved by the same loop as any
other: the same steps, attempts and ends.
"""

import numpy as np

from libc.math cimport NAN
from libc.stdint cimport int32_t, uint8_t
from libc.string cimport memcpy

from arael.runtime.address cimport address
from arael.runtime.evaluation.compiled cimport ComponentLanes, Evaluation
from arael.runtime.linear.compiled cimport LinearSolver
from arael.runtime.raw cimport bytes_at


cdef _copied(const void* values, Py_ssize_t n):
    """The first `n` doubles as an array of their own."""
    found = np.empty(n)
    cdef double[::1] to = found
    if n:
        memcpy(&to[0], values, n * sizeof(double))
    return found


cdef _put(found, void* to, Py_ssize_t n):
    """Write an array of `n` doubles."""
    array = np.ascontiguousarray(found, dtype=np.float64)
    if array.shape != (n,):
        raise ValueError(f"expected {n} scalars, found shape {array.shape}")
    cdef const double[::1] values = array
    if n:
        memcpy(to, &values[0], n * sizeof(double))


cdef class RemoteEvaluation(Evaluation):
    """Cost and linearisation of a problem in f64, by the object `parts`.

    ``parts.cost(arrays)`` and ``parts.linearise(arrays)`` get the states, one array (rows, state)
    per entity. The second returns the cost, J'r (n,) and the diagonal of J'J (n,); no other values
    of J'J are known here. What they raise ends the solve.

    Where connected components are solved separately, ``parts.costs(arrays)`` returns the costs of
    each, (components + 1,), and ``parts.choose(active)`` gets those that go on, as `RemoteLanes`.
    """

    cdef public object parts

    def component_lanes(self, partition):
        """The components, by which `parts` is asked for costs from now on."""
        return RemoteLanes(self, partition)

    def is_guarded(self, bint guarded):
        """Set whether a guard of some instance reads parameters."""
        self.guarded = guarded

    cdef double cost(self, int which) noexcept nogil:
        with gil:
            return self._cost_of_parts(which)

    cdef double _cost_of_parts(self, int which) noexcept:
        try:
            return self.parts.cost(self.states.arrays[which])
        except BaseException as error:
            self.raised.keep(error)
        return NAN

    cdef void costs(self, int which, ComponentLanes chosen) noexcept nogil:
        with gil:
            self._costs_of_parts(which, chosen)

    cdef void _costs_of_parts(self, int which, ComponentLanes chosen) noexcept:
        cdef RemoteLanes lanes = <RemoteLanes>chosen
        try:
            _put(
                self.parts.costs(self.states.arrays[which]), &lanes._values[0],
                lanes.components + 1)
        except BaseException as error:
            lanes._values[:] = NAN
            self.raised.keep(error)

    cdef void guard(self) noexcept nogil:
        pass  # each part evaluates its guards at the states that it gets

    cdef double linearise(
        self, void* gradient, void* values, ComponentLanes chosen
    ) noexcept nogil:
        with gil:
            return self._linearise_parts(gradient, values)

    cdef double _linearise_parts(self, void* gradient, void* values) noexcept:
        cdef Py_ssize_t i
        cdef double cost
        cdef const double[::1] own
        try:
            cost, first, second = self.parts.linearise(self.states.arrays[self.states.current])
            _put(first, gradient, self.size)
            own = np.ascontiguousarray(second, dtype=np.float64)
            for i in range(self.size):
                (<double*>values)[self.totals.diagonal_at[i]] = own[i]
            self.totals.hold(gradient, values)
            return cost
        except BaseException as error:
            self.raised.keep(error)
        return NAN


cdef class RemoteLanes(ComponentLanes):
    """The components of a problem in parts: their costs, and which of them go on.

    ``parts.choose(active)`` gets a mask (components + 1,) of those that go on; the last is for
    instances that read nothing that is solved for. Others need no more be evaluated.
    """

    cdef RemoteEvaluation _evaluation
    cdef double[::1] _values

    def __init__(self, RemoteEvaluation evaluation, partition):
        super().__init__(evaluation, partition)
        self._evaluation, self._values = evaluation, np.zeros(self.components + 1)
        evaluation.parts.choose(np.ones(self.components + 1, dtype=bool))

    cdef void choose(self, const uint8_t* active) noexcept nogil:
        with gil:
            self._choose_in_parts(active)

    cdef void _choose_in_parts(self, const uint8_t* active) noexcept:
        try:
            marks = np.frombuffer(bytes_at(active, self.components + 1), np.bool_)
            self._evaluation.parts.choose(marks.copy())
        except BaseException as error:
            self._evaluation.raised.keep(error)

    cdef void add(self, double* total) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self.components + 1):
            total[k] += self._values[k]


cdef class RemoteBox(Box):
    """Bounds of a problem in parts, and the curvature of its J'J along a step.

    ``parts.hold(scalars)`` gets the scalars that stand at a bound, which the next factors leave
    out; ``parts.curvature(step)`` returns ``step' H step`` of each component (1,) or (components,).
    """

    cdef public object parts

    cdef void hold(self, void* gradient, void* values) noexcept nogil:
        with gil:
            self._hold_of_parts(<double*>gradient, values)

    cdef void _hold_of_parts(self, double* gradient, void* values) noexcept:
        cdef Py_ssize_t k
        cdef list moving = [
            self._scalar[k] for k in range(self.count) if gradient[self._scalar[k]] != 0
        ]
        Box.hold(self, gradient, values)
        try:
            self.parts.hold(np.array([i for i in moving if gradient[<Py_ssize_t>i] == 0], np.int64))
        except BaseException as error:
            self._evaluation.raised.keep(error)

    cdef void curvature(
        self, const void* values, const void* step, const int32_t* component, double* total
    ) noexcept nogil:
        with gil:
            self._curvature_of_parts(step, total)

    cdef void _curvature_of_parts(self, const void* step, double* total) noexcept:
        cdef Py_ssize_t k
        try:
            for k, found in enumerate(self.parts.curvature(_copied(step, self._evaluation.size))):
                total[k] += found
        except BaseException as error:
            total[0] = NAN
            self._evaluation.raised.keep(error)


cdef class RemoteSolver(LinearSolver):
    """Steps of a problem in parts.

    ``parts.factor(diagonal, b)`` gets the damped diagonal and the right-hand side and returns
    ``(0, x)``, or 1 + the scalar whose pivot failed and None; ``parts.solve(b)`` solves with the
    factor that there is. All are (n,) f64 in the order of the pattern.
    """

    cdef public object parts
    cdef object _found

    def __init__(self, pattern, parts):
        super().__init__(pattern, False)
        self.parts = parts

    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b
    ) noexcept nogil:
        with gil:
            return self._factor_parts(diagonal, b)

    cdef Py_ssize_t _factor_parts(self, const void* diagonal, const void* b) noexcept:
        try:
            status, self._found = self.parts.factor(
                _copied(diagonal, self.n), _copied(b, self.n))
            return status
        except BaseException as error:
            self.raised.keep(error)
        return 1

    cdef void finish(self, void* b) noexcept nogil:
        with gil:
            self._take(self._found, b)

    cdef void solve(self, void* b) noexcept nogil:
        with gil:
            self._solve_parts(b)

    cdef void _solve_parts(self, void* b) noexcept:
        try:
            self._take(self.parts.solve(_copied(b, self.n)), b)
        except BaseException as error:
            self.raised.keep(error)

    cdef void _take(self, found, void* b) noexcept:
        try:
            _put(found, b, self.n)
        except BaseException as error:
            self.raised.keep(error)


def curvature_of(Box box, values, step, partition=None):
    """Return ``step' H step`` of a problem in f64, with the values (value_count,) of its J'J.

    It is that of each component of the partition (count,), or without one of all (1,).
    """
    cdef const double[::1] first = np.ascontiguousarray(values, dtype=np.float64)
    cdef const double[::1] second = np.ascontiguousarray(step, dtype=np.float64)
    cdef const int32_t* component = NULL
    found = np.zeros(1 if partition is None else partition.count)
    cdef double[::1] total = found
    if len(first) and len(second):
        if partition is not None:
            component = <const int32_t*>address(partition.of_scalar, np.int32, len(second))
        box.curvature(&first[0], &second[0], component, &total[0])
    return found
