"""Preconditioned conjugate gradients on the reduced system of a block elimination.

M. R. Hestenes and E. Stiefel, J. Res. Nat. Bur. Standards 49 (1952); on the Schur complement of
bundle adjustment: S. Agarwal, N. Snavely, S. Seitz, R. Szeliski, "Bundle adjustment in the large",
ECCV 2010. Started from zero, every iterate x of the method satisfies ``x'(b - S x) = 0``, so that
the predicted decrease of an inexact step is computed as for an exact one.

Iterations end when the residual in the preconditioner's norm has fallen to a forcing term, chosen
as by S. Eisenstat and H. Walker, "Choosing the forcing terms in an inexact Newton method", SIAM
J. Sci. Comput. 17 (1996), choice 2: large far from the optimum, small near it.
"""

import numpy as np

from libc.math cimport NAN, isfinite, sqrt

from arael.runtime.address cimport address, writable

from arael.runtime.compiled import aligned_zeros


# Of Eisenstat and Walker: eta = GAMMA (norm of the gradient / norm of the one before)^2, with a
# lower bound while eta was large.
cdef double GAMMA = 0.9, LARGE = 0.1
# Factor of the forcing term after a rejected step.
cdef double CARE = 0.1


cdef class ConjugateSolver(LinearSolver):
    """Elimination of an independent set, and an iterative solution of the reduced system.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    reduction : Reduction
    blocks : Products
        Of the whole reduced system if `formed`, else of the kept entities before the reduction.
    formed : bool
    parts : sequence of (Products, LinearSolver)
        Preconditioners: part of the reduced system and a solver for it. The first positive definite
        one is used; the last must be block diagonal, so that its failure is that of the system.
    tolerance, floor : float
        Bounds of the forcing term, relative to the right-hand side in the preconditioner's norm.
    iterations : int
        Maximum iterations per solve.

    Attributes
    ----------
    solves, steps : int
        Number of solves and total iterations.
    """

    cdef readonly Py_ssize_t solves, steps
    cdef readonly double forcing        # of the last solve
    cdef Elimination _elimination
    cdef Sums _sums
    cdef object _keep
    cdef LinearSolver _jacobi, _better
    cdef Sums _jacobi_sums, _better_sums
    cdef bint _formed, _plain
    cdef const Block* _blocks
    cdef Py_ssize_t _count, _most
    cdef double _tolerance, _floor, _norm
    cdef void* _x
    cdef void* _r
    cdef void* _z
    cdef void* _p
    cdef void* _q

    def __init__(
        self, pattern, bint single, reduction, blocks, bint formed, parts, *, double tolerance=0.1,
        double floor=1e-6, Py_ssize_t iterations=500,
    ):
        super().__init__(pattern, single)
        self._elimination = Elimination(reduction, self.dtype)
        self._sums = Sums(self._elimination, blocks, self.dtype)
        self._formed = formed
        last_products, self._jacobi = parts[len(parts) - 1]
        self._jacobi_sums = Sums(self._elimination, last_products, self.dtype)
        if len(parts) > 1:
            first_products, self._better = parts[0]
            self._better_sums = Sums(self._elimination, first_products, self.dtype)
        # A tolerance below the rounding of the sums has no effect.
        self._floor = max(floor, 4 * float(np.finfo(self.dtype).eps))
        self._tolerance, self._most = max(tolerance, self._floor), iterations
        table = _table(blocks.pattern)
        vectors = [aligned_zeros(self._elimination.n, self.dtype) for _ in range(5)]
        self._keep = (table, vectors)
        self._count = len(table) - 1
        self._blocks = <const Block*>address(table, BLOCK)
        self._x, self._r = writable(vectors[0], self.dtype), writable(vectors[1], self.dtype)
        self._z, self._p = writable(vectors[2], self.dtype), writable(vectors[3], self.dtype)
        self._q = writable(vectors[4], self.dtype)
        self._norm = 0
        self.forcing = self._tolerance
        self.plan = {
            "solver": "schur_pcg",
            "n": self.n,
            "eliminated": int(reduction.eliminated.sum()),
            "reduced_n": self._elimination.n,
            "formed": bool(formed),
            "nnz_l": reduction.factor_size + reduction.stored_size + blocks.pattern.value_count,
        }

    def use_threads(self, int threads):
        """Set the number of threads of the elimination and the preconditioners."""
        self.threads = self._elimination.threads = threads
        self._jacobi.use_threads(threads)
        if self._better is not None:
            self._better.use_threads(threads)

    def report(self):
        """Return the plan with the number of iterations so far."""
        return {**self.plan, "solves": self.solves, "iterations": self.steps}

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        cdef Py_ssize_t status
        if self.single:
            status = self._reduce(<const float*>values, <const float*>diagonal)
        else:
            status = self._reduce(<const double*>values, <const double*>diagonal)
        if status:
            return status
        self._plain = self._better is None
        if not self._plain:
            # A part of a positive definite matrix need not be positive definite.
            self._plain = self._better.factor(
                self._better_sums._values, self._better_sums._damped) != 0
        if self._plain:
            status = self._jacobi.factor(self._jacobi_sums._values, self._jacobi_sums._damped)
        return 1 + self._elimination._scalar[status - 1] if status else 0

    cdef void solve(self, void* b) noexcept nogil:
        if self.single:
            self._solve(<float*>b)
        else:
            self._solve(<double*>b)

    cdef Py_ssize_t _reduce(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t status = self._elimination.eliminate(values, diagonal)
        if status:
            return status
        self._sums.form(values, diagonal)
        if self._better is not None:
            self._better_sums.form(values, diagonal)
        self._jacobi_sums.form(values, diagonal)
        complete(self._blocks, self._count, <real*>self._sums._values,
                 <const real*>self._sums._damped)
        return 0

    cdef void _solve(self, real* b) noexcept nogil:
        cdef Py_ssize_t i
        self._force(sqrt(dot(self.n, b, b)))
        self._elimination.descend(b, <real*>self._r)
        if not self._iterate(<real*>self._x):
            for i in range(self.n):
                b[i] = <real>NAN
            return
        self._elimination.ascend(<real*>self._x, b)

    def restart(self):
        """Reset the norms of an earlier solve, so that a warm run equals a cold one."""
        self._norm, self.forcing = 0, self._tolerance
        self.solves = self.steps = 0

    cdef void _force(self, double norm) noexcept nogil:
        """Next forcing term, from the norm of the right-hand side and that of the one before."""
        cdef double before = self.forcing, ratio
        if norm == self._norm:
            self.forcing = CARE * before
        elif self._norm > 0 and isfinite(norm):
            ratio = norm / self._norm
            self.forcing = GAMMA * ratio * ratio
            if GAMMA * before * before > LARGE:
                self.forcing = max(self.forcing, GAMMA * before * before)
        else:
            self.forcing = self._tolerance
        self.forcing = min(max(self.forcing, self._floor), self._tolerance)
        self._norm = norm

    cdef bint _iterate(self, real* x) noexcept nogil:
        """Solve for the right-hand side in `_r`; false if the matrix is not positive definite.

        Sums in f64.
        """
        cdef Py_ssize_t n = self._elimination.n, i
        cdef real* r = <real*>self._r
        cdef real* z = <real*>self._z
        cdef real* p = <real*>self._p
        cdef real* q = <real*>self._q
        cdef double rho, first, curvature, before
        cdef real step, turn
        self.solves += 1
        for i in range(n):
            x[i] = 0
            z[i] = r[i]
        self._precondition(z)
        rho = first = dot(n, r, z)
        if not isfinite(rho):
            return False
        for i in range(n):
            p[i] = z[i]
        for _ in range(self._most):
            if rho <= self.forcing * self.forcing * first:
                return True
            self._elimination.multiply(self._count, self._blocks, <const real*>self._sums._values,
                                       self._formed, p, q)
            self.steps += 1
            curvature = dot(n, p, q)
            if not curvature > 0 or not isfinite(curvature):
                return False
            step = <real>(rho / curvature)
            for i in range(n):
                x[i] += step * p[i]
                r[i] -= step * q[i]
                z[i] = r[i]
            self._precondition(z)
            before = rho
            rho = dot(n, r, z)
            if not isfinite(rho):
                return False
            turn = <real>(rho / before)
            for i in range(n):
                p[i] = z[i] + turn * p[i]
        return True

    cdef void _precondition(self, void* z) noexcept nogil:
        if self._plain:
            self._jacobi.solve(z)
        else:
            self._better.solve(z)


cdef double dot(Py_ssize_t n, const real* a, const real* b) noexcept nogil:
    """Inner product with four partial sums."""
    cdef double s0 = 0, s1 = 0, s2 = 0, s3 = 0
    cdef Py_ssize_t i, whole = n - n % 4
    for i in range(0, whole, 4):
        s0 += <double>a[i] * b[i]
        s1 += <double>a[i + 1] * b[i + 1]
        s2 += <double>a[i + 2] * b[i + 2]
        s3 += <double>a[i + 3] * b[i + 3]
    for i in range(whole, n):
        s0 += <double>a[i] * b[i]
    return (s0 + s1) + (s2 + s3)


cdef void complete(
    const Block* blocks, Py_ssize_t count, real* values, const real* diagonal
) noexcept nogil:
    """Complete the diagonal blocks: mirror the lower triangle, insert the diagonal."""
    cdef Py_ssize_t k, i, j, w
    cdef real* block
    for k in range(count):
        if blocks[k].row != blocks[k].column:
            continue
        block, w = values + blocks[k].place, blocks[k].width
        for i in range(w):
            for j in range(i):
                block[j * w + i] = block[i * w + j]
            block[i * w + i] = diagonal[i]
        diagonal += w


def _table(pattern):
    """Blocks of a pattern in the form of the kernel, with an end marker."""
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    lengths = -(-pattern.sizes // PADDING) * PADDING
    begin = np.cumsum(lengths) - lengths
    table = np.zeros(len(columns) + 1, dtype=BLOCK)
    table["place"][: len(columns)] = pattern.value_start
    table["row"][: len(columns)] = begin[pattern.rows]
    table["column"][: len(columns)] = begin[columns]
    table["height"][: len(columns)] = pattern.sizes[pattern.rows]
    table["width"][: len(columns)] = pattern.sizes[columns]
    return table
