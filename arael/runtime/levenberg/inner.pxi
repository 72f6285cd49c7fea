"""Inner iterations: a trial state is judged after the eliminated entities were solved again.

Of a bundle, points are eliminated from the linear system: given the cameras, each depends on its
own observations only. A step of the cameras moves points along their linear model, which a distant
point leaves at once; its cost then rejects a good step of the cameras. So at each trial state every
eliminated entity takes a Gauss-Newton step of its own, from its own rows, before costs are
compared. This approximates variable projection (Golub and Pereyra, "The differentiation of
pseudo-inverses and nonlinear least squares problems whose variables separate", 1973), as the inner
iterations of Ceres do.

An entity takes the shortest of the lengths 1, 1/4, 1/16 and 1/64 of its step that brings most of
what the best of them brings: a point that is better off far away does not go farther than it helps.
"""

import numpy as np

from libc.math cimport isfinite, sqrt
from libc.string cimport memcpy, memset

from arael.runtime.address cimport address, writable
from arael.runtime.evaluation.compiled cimport ComponentLanes, Evaluation
from arael.runtime.linear.compiled cimport Entity

# Ratio of successive lengths, and the part of the best decrease that a length must bring.
cdef double SHORTER = 0.25
cdef double INNER_SHARE = 0.9


cdef class InnerSteps:
    """Inner iterations of one solve.

    Parameters
    ----------
    evaluation : Evaluation
        The problem.
    entities : (count + 1,) ENTITY
        The eliminated entities, as `Reduction` has them.
    partition : object
        `count`, and `of_instance`: for each group the number of the eliminated entity that each
        active instance reads, or `count`.
    floor : float
        Multiple of the diagonal of each block that is added to it.
    """

    def __init__(self, Evaluation evaluation, entities, partition, double floor):
        # Imported here for start-up time: most solves take no inner iterations.
        from arael.runtime.linear.compiled import ENTITY

        self.count, self._floor = partition.count, floor
        self._lanes = ComponentLanes(evaluation, partition)
        self._entities = <const Entity*>address(entities, ENTITY, self.count + 1)
        gradient, values = evaluation.workspace()
        vectors = np.zeros((2, max(evaluation.size, 1)), dtype=evaluation.dtype)
        largest = int(entities["size"].max(initial=1))
        numbers = np.zeros((LENGTHS + 2) * (self.count + 1) + largest * (largest + 1))
        self._keep = (entities, gradient, values, vectors, numbers)
        self._gradient = writable(gradient, evaluation.dtype)
        self._values = writable(values, evaluation.dtype)
        self._base = writable(vectors[0], evaluation.dtype)
        self._own = writable(vectors[1], evaluation.dtype)
        self._promise = <double*>writable(numbers, np.float64)
        self._before = self._promise + self.count + 1
        self._after = self._before + self.count + 1
        self._work = self._after + LENGTHS * (self.count + 1)

    cdef void improve(
        self, Evaluation evaluation, Vectors vectors, double least
    ) noexcept nogil:
        if evaluation.single:
            self._improve(evaluation, vectors, <float*>vectors.step, least)
        else:
            self._improve(evaluation, vectors, <double*>vectors.step, least)

    cdef void _costs(self, Evaluation evaluation, double* total) noexcept nogil:
        """Costs of the entities at the trial state."""
        evaluation.costs(1 - evaluation.states.current, self._lanes)
        memset(total, 0, (self.count + 1) * sizeof(double))
        self._lanes.add(total)

    cdef void _improve(
        self, Evaluation evaluation, Vectors vectors, real* step, double least
    ) noexcept nogil:
        cdef Py_ssize_t k, n = evaluation.size
        cdef long long i
        cdef const Entity* e
        cdef real* base = <real*>self._base
        cdef real* own = <real*>self._own
        cdef int tried
        cdef double length = 1
        # The derivatives are those of the accepted state: for a moment it is the trial state.
        evaluation.states.accept()
        evaluation.linearise(self._gradient, self._values, None)
        evaluation.states.accept()
        self._solve(<const real*>self._gradient, <const real*>self._values, own)
        self._costs(evaluation, self._before)
        memcpy(base, step, n * sizeof(real))
        for tried in range(LENGTHS):
            for k in range(self.count):
                e = &self._entities[k]
                for i in range(e.scalar, e.scalar + e.size):
                    step[i] = <real>(base[i] + length * own[i])
            evaluation.states.move(step, vectors.threads)
            self._costs(evaluation, self._after + tried * (self.count + 1))
            if tried == 0 and self._missed(self._after) <= least:
                break
            length *= SHORTER
        for k in range(self.count):
            e = &self._entities[k]
            length = self._best_length(k, tried)
            for i in range(e.scalar, e.scalar + e.size):
                step[i] = <real>(base[i] + length * own[i])
        evaluation.states.move(step, vectors.threads)

    cdef double _missed(self, const double* after) noexcept nogil:
        """Decrease that entities predict whose step falls short of it."""
        cdef Py_ssize_t k
        cdef double missed = 0
        for k in range(self.count):
            if not self._before[k] - after[k] >= INNER_SHARE * self._promise[k]:
                missed += self._promise[k]
        return missed

    cdef double _best_length(self, Py_ssize_t k, int tried) noexcept nogil:
        """The shortest length that brings most of what the best brings; 0 if none helps."""
        cdef double best = 0, length = 1, found = 0, decrease
        cdef int t
        for t in range(min(tried + 1, LENGTHS)):
            decrease = self._before[k] - self._after[t * (self.count + 1) + k]
            if decrease > best:  # not NaN
                best = decrease
        for t in range(min(tried + 1, LENGTHS)):
            decrease = self._before[k] - self._after[t * (self.count + 1) + k]
            if best > 0 and decrease >= INNER_SHARE * best:
                found = length
            length *= SHORTER
        return found

    cdef void _solve(self, const real* gradient, const real* values, real* own) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self.count):
            self._promise[k] = self._own_step(&self._entities[k], gradient, values, own)

    cdef double _own_step(
        self, const Entity* e, const real* gradient, const real* values, real* own
    ) noexcept nogil:
        """The step of one entity and the decrease it predicts; none if its block is singular.

        Of a diagonal block, what is stored below the diagonal counts.
        """
        cdef long long d = e.size, i, j, m
        cdef const real* block = values + e.source
        cdef double* factor = self._work
        cdef double* x = self._work + d * d
        cdef double s, promise = 0
        for i in range(d):
            own[e.scalar + i] = 0
        for i in range(d):
            for j in range(i + 1):
                s = block[i * d + j]
                if i == j:
                    s += self._floor * s
                for m in range(j):
                    s -= factor[i * d + m] * factor[j * d + m]
                if i != j:
                    factor[i * d + j] = s / factor[j * d + j]
                elif s > 0 and isfinite(s):
                    factor[i * d + i] = sqrt(s)
                else:
                    return 0
        for i in range(d):
            s = -gradient[e.scalar + i]
            for m in range(i):
                s -= factor[i * d + m] * x[m]
            x[i] = s / factor[i * d + i]
            promise += x[i] * x[i]  # |L^-1 g|^2 = g' H^-1 g
        if not isfinite(promise):
            return 0
        for i in range(d - 1, -1, -1):
            s = x[i]
            for m in range(i + 1, d):
                s -= factor[m * d + i] * x[m]
            x[i] = s / factor[i * d + i]
            own[e.scalar + i] = <real>x[i]
        return promise
