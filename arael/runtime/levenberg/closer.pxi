"""The promise of a linearisation by conjugate gradients, with the last factor as preconditioner.

Where the matrix has grown in a few directions, by a thousand times as the curvature of points that
come near a camera does, the last factor promises far too much of the gradient in them. Each step of
conjugate gradients takes one such direction out (Hestenes and Stiefel, "Methods of conjugate
gradients for solving linear systems", 1952). With z = M^-1 r of the residual r, the steps so far
show ``sum alpha r'z`` of ``g' H^-1 g``, which only grows; ``r'z`` is what M promises of the rest.
"""

import numpy as np

from arael.runtime.address cimport writable
from arael.runtime.linear.compiled cimport LinearSolver

# Steps, each with a product and two triangular solves: an attempt takes a factorisation.
cdef int STEPS = 5
# Part of the curvature of M along a direction that must be left: see `ends.by_last_factor`.
cdef double ALIKE_CURVATURE = 0.5


cdef void widen(const real* from_, Py_ssize_t n, double* to) noexcept nogil:
    cdef Py_ssize_t i
    for i in range(n):
        to[i] = from_[i]


cdef void narrow(const double* from_, Py_ssize_t n, real* to) noexcept nogil:
    cdef Py_ssize_t i
    for i in range(n):
        to[i] = <real>from_[i]


cdef void onward(
    Py_ssize_t n, const real* z, double ratio, double* direction
) noexcept nogil:
    """The next direction: z and a part of the last one."""
    cdef Py_ssize_t i
    for i in range(n):
        direction[i] = <double>z[i] + ratio * direction[i]


cdef double dot(Py_ssize_t n, const double* a, const double* b) noexcept nogil:
    cdef Py_ssize_t i
    cdef double found = 0
    for i in range(n):
        found += a[i] * b[i]
    return found


cdef double dot_with(Py_ssize_t n, const double* a, const real* b) noexcept nogil:
    cdef Py_ssize_t i
    cdef double found = 0
    for i in range(n):
        found += a[i] * <double>b[i]
    return found


cdef class Closer:
    """Vectors for the steps.

    Parameters
    ----------
    n : int
        Scalars of the system.
    """

    def __init__(self, Py_ssize_t n):
        vectors = np.empty((4, max(n, 1)))
        self._keep = vectors
        self._residual = <double*>writable(vectors[0], np.float64, n)
        self._direction = <double*>writable(vectors[1], np.float64, n)
        self._product = <double*>writable(vectors[2], np.float64, n)
        self._solution = <double*>writable(vectors[3], np.float64, n)

    cdef double promise(
        self, Vectors vectors, Box box, LinearSolver solver, double promise, double most
    ) noexcept nogil:
        cdef Py_ssize_t n = vectors.n, i
        cdef double* r = self._residual
        cdef double* p = self._direction
        cdef double* x = self._solution
        cdef double shown = 0, rest = promise, old = promise, alpha, curvature, before
        cdef int step
        if vectors.single:
            widen(<const float*>vectors.gradient, n, r)
            widen(<const float*>vectors.step, n, p)
        else:
            widen(<const double*>vectors.gradient, n, r)
            widen(<const double*>vectors.step, n, p)
        for i in range(n):
            r[i] = -r[i]
            x[i] = 0
        for step in range(STEPS + 1):
            box.product(vectors.values, p, self._product)
            curvature = dot(n, p, self._product)
            # `old` is the curvature of M along the direction. Where less than half of it is left, M
            # says nothing of what it promises.
            if not curvature >= ALIKE_CURVATURE * old:
                return -1
            if step > 0 and shown + rest * max(1.0, old / curvature) <= most:
                if vectors.single:
                    narrow(x, n, <float*>vectors.step)
                else:
                    narrow(x, n, <double*>vectors.step)
                return shown + rest * max(1.0, old / curvature)
            if step == STEPS:
                break
            alpha = rest / curvature
            shown += alpha * rest
            if not shown <= most:
                return -1
            for i in range(n):
                x[i] += alpha * p[i]
                r[i] -= alpha * self._product[i]
            before = rest
            if vectors.single:
                narrow(r, n, <float*>vectors.step)
                solver.solve(vectors.step)
                rest = dot_with(n, r, <const float*>vectors.step)
            else:
                narrow(r, n, <double*>vectors.step)
                solver.solve(vectors.step)
                rest = dot_with(n, r, <const double*>vectors.step)
            if not rest >= 0:
                return -1
            # Directions are conjugate in M, too.
            old = rest + (rest / before) ** 2 * old
            if vectors.single:
                onward(n, <const float*>vectors.step, rest / before, p)
            else:
                onward(n, <const double*>vectors.step, rest / before, p)
        return -1
