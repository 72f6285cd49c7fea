"""Rank, dependent equations, dependencies and null space of a sparse matrix."""

import numpy as np

from libc.stdint cimport int64_t

from arael.runtime.address cimport address, writable
from arael.runtime.compiled cimport Interruption

from arael.runtime.compiled import InterruptedWork
from arael.runtime.orthogonal.results import Dependency, Vectors
from arael.runtime.orthogonal.settle import settle


cdef class RankQR(ScaledFactor):
    """QR factorisation of J' that finds the rank of J, its dependent rows and its null space.

    J has m rows, called equations, and n columns, called unknowns. The pattern is analysed once;
    `factor` may be called for many matrices of that pattern.

    Parameters
    ----------
    m, n : int
    indptr : (m + 1,) int32
        First entry of each equation, in compressed sparse rows.
    indices : (entries,) int32
        Unknown of each entry, in any order; entries at the same place are added up.
    priority : (m,) int32, optional
        Of equations that depend on each other, those with the largest number are called dependent;
        of equal numbers, the later one. All 0 by default.
    tolerance : float, optional
        An equation is dependent if the distance to the span of others is at most this part of the
        greatest length, all scaled. 20 (m + n) eps by default.
    interruption : Interruption, optional
        A request of any thread to break off. It is looked at per equation of the analysis, per
        front of the factor, per dependent equation and per vector of the null space. A factor that
        was broken off is none; `factor` may be called again.

    Raises
    ------
    ValueError
        If the arrays are not a pattern of m rows and n columns.
    InterruptedWork
        If it was broken off; so do `factor`, `dependent` and what needs it, and `null_vectors`.
    """

    def __init__(
        self, int m, int n, indptr, indices, priority=None, tolerance=None,
        Interruption interruption=None,
    ):
        if m < 0 or n < 0:
            raise ValueError(f"expected a shape of numbers that are not negative, found ({m}, {n})")
        self.interruption = interruption if interruption is not None else Interruption()
        eps = np.finfo(np.float64).eps
        indptr, indices = np.array(indptr, dtype=np.int32), np.array(indices, dtype=np.int32)
        self.priority = (
            np.zeros(m, np.int32) if priority is None else np.array(priority, dtype=np.int32)
        )
        _check(m, n, indptr, indices, self.priority)
        ScaledFactor.__init__(
            self, m, n, indptr, indices,
            20 * max(m + n, 1) * eps if tolerance is None else tolerance, self.interruption,
        )

    def factor(self, entries, scale=None, shortest=0.0):
        """Factor the matrix with these entries.

        Parameters
        ----------
        entries : (entries,) float64, in the order of `indices`
        scale : (n,) float64, optional
            Scales of the unknowns, positive: the factor is that of J diag(scale), and norms of
            directions are those of `d / scale`. Without it, powers of two that balance the
            entries; entries below 4 eps of the greatest of their equation are then zero.
        shortest : float, optional
            Length that an equation has, in scaled unknowns, where its entries do not cancel out.
            Those that are shorter are not scaled up to others: what is left of them may be
            rounding. 0, where that is not known, scales all.

        Raises
        ------
        ValueError
            For arrays of another length, for an entry or scale that is not finite, and for a
            negative length.
        """
        if not shortest >= 0.0:
            raise ValueError(f"expected a shortest length of at least 0, found {shortest}")
        self.shortest = shortest
        entries = _doubles(entries, len(self.indices), "entries")
        cdef const double* scales = NULL
        if scale is not None:
            scale = _doubles(scale, self.n, "scales")
            wrong = np.flatnonzero(~(np.isfinite(scale) & (scale > 0)))
            if len(wrong):
                raise ValueError(
                    f"the scale of unknown {wrong[0]} is {scale[wrong[0]]}, expected a positive "
                    "number"
                )
            scales = <const double*>address(scale, np.float64, self.n)
        cdef const double* numbers = <const double*>address(entries, np.float64)
        cdef int wrong_equation
        with nogil:
            wrong_equation = self.factor_entries(numbers, scales)
        self.settled = None
        if wrong_equation < 0:
            raise InterruptedWork
        if wrong_equation:
            raise ValueError(f"equation {wrong_equation - 1} has an entry that is not finite")

    def _look(self):
        if self.interruption.look():
            raise InterruptedWork

    def _require(self):
        if not self.factored:
            raise ValueError("the matrix has no factor; call factor(entries) first")

    @property
    def rank(self):
        """Number of independent equations."""
        self._require()
        return self.part.rank - self.copies

    @property
    def nullity(self):
        """Number of free directions, n - rank."""
        return self.n - self.rank

    @property
    def smallest_kept(self):
        """Least remaining length of an independent equation, scaled; infinite if there is none."""
        self._require()
        return self.part.smallest_kept if self.part.rank > self.copies else float("inf")

    @property
    def largest_dropped(self):
        """Greatest remaining length of a dependent equation, scaled; 0 if there is none."""
        self._require()
        return self.part.largest_dropped

    @property
    def threshold(self):
        """Remaining length up to which equations were found dependent."""
        self._require()
        return self.dead

    @property
    def gap(self):
        """Smallest kept over largest dropped length: how safe the rank is; infinite if none was."""
        kept, dropped = self.smallest_kept, self.largest_dropped
        return kept / dropped if dropped else float("inf")

    @property
    def scales(self):
        """Scales of equations (m,) and of unknowns (n,), as used."""
        self._require()
        equations, unknowns = np.empty(self.m), np.empty(self.n)
        cdef double[::1] of_equations = equations, of_unknowns = unknowns
        cdef int i
        for i in range(self.m):
            of_equations[i] = self.of_equations[i]
        for i in range(self.n):
            of_unknowns[i] = self.of_unknowns[i]
        return equations, unknowns

    @property
    def dependent(self):
        """Dependent equations, ascending; see the parameter `priority`."""
        return self._settle().dependent.copy()

    @property
    def independent(self):
        """Mask (m,) of the equations that are not dependent: a basis of the row space."""
        found = np.ones(self.m, dtype=np.bool_)
        found[self._settle().dependent] = False
        return found

    def _settle(self):
        """Dependencies of the dependent equations, after exchanges by priority."""
        self._require()
        if self.settled is None:
            self.settled = settle(self._found(), self.priority)
        return self.settled

    def _found(self):
        """Equations without a pivot, each with its dependency: equations, scaled factors."""
        cdef const Plan* a = &self.analysis.plan
        cdef int i, p, count
        cdef double remainder, one
        cdef double[2] pair = [-1.0, 1.0]
        cdef int[2] at
        found = []
        equations, factors = np.empty(self.m, np.int32), np.empty(self.m)
        cdef int[::1] equation = equations
        cdef double[::1] factor = factors
        for i in range(self.m, self.m + self.copies):
            if self.part.slot_of[a.position[i]] < 0:
                # As other equations make copies equal, there are dependent ones among them.
                at[0], at[1] = self.copy_at[self.start[i]], self.copy_at[self.start[i] + 1]
                count = self.dependency_into(2, at, pair, &equation[0], &factor[0], &remainder)
                for p in range(count):
                    factor[p] /= self.of_equations[equation[p]]
                found.append((-1, equations[:count].copy(), factors[:count].copy()))
        for i in range(self.m):
            if self.part.slot_of[a.position[i]] >= 0:
                continue
            self._look()
            count = self.dependency_into(
                self.start[i + 1] - self.start[i], self.at + self.start[i],
                self.entries + self.start[i], &equation[0], &factor[0], &remainder,
            )
            one = self.of_equations[i]
            for p in range(count):
                factor[p] *= one / self.of_equations[equation[p]]
            found.append((i, equations[:count].copy(), factors[:count].copy()))
        return found

    def dependency(self, int equation):
        """How a dependent equation follows from independent ones.

        Returns
        -------
        Dependency
            Its remainder is that of the equation as it was found.

        Raises
        ------
        ValueError
            If the equation is not among `dependent`.
        """
        rows = self._settle().rows
        if equation not in rows:
            raise ValueError(f"equation {equation} is not a dependent one")
        equations, factors = rows[equation]
        one = self.of_equations[equation]
        scaled = np.array([self.of_equations[i] for i in equations], dtype=np.float64)
        cdef Py_ssize_t begin = self.start[equation], end = self.start[equation + 1]
        rest = self._combination(self.indices[begin:end], self.numbers[begin:end]).remainder
        return Dependency(equations, factors * scaled / one if one else factors, rest)

    def dependency_of(self, unknowns, values):
        """Combination of independent equations that is nearest to a row c, in scaled unknowns.

        Parameters
        ----------
        unknowns : (k,) int32, places of the entries of c
        values : (k,) float64

        Returns
        -------
        Dependency
        """
        made = self._combination(unknowns, values)
        swapped = self._settle().swapped
        if not any(int(i) in swapped for i in made.equations):
            return made
        # Equations with a pivot that are called dependent: through those that replace them.
        sums = np.zeros(self.m)
        scales = self.scales[0]
        for i, f in zip(made.equations, made.factors):
            if int(i) in swapped:
                equations, factors = swapped[int(i)]
                sums[equations] += f / scales[i] * factors
            else:
                sums[i] += f / scales[i]
        at = np.flatnonzero(np.abs(sums) > NEGLIGIBLE * np.abs(sums).max()).astype(np.int32)
        return Dependency(at, sums[at] * scales[at], made.remainder)

    def _combination(self, unknowns, values):
        """Combination of the equations with a pivot."""
        self._require()
        unknowns = np.ascontiguousarray(unknowns, dtype=np.int32)
        values = _doubles(values, len(unknowns), "values")
        if len(unknowns) and not (0 <= unknowns.min() and unknowns.max() < self.n):
            raise ValueError(f"expected unknowns from 0 to {self.n - 1}, found {unknowns}")
        if not np.isfinite(values).all():
            raise ValueError("the row has an entry that is not finite")
        cdef const int* at = <const int*>address(unknowns, np.int32)
        cdef const double* value = <const double*>address(values, np.float64)
        equations, factors = np.empty(max(self.m, 1), np.int32), np.empty(max(self.m, 1))
        cdef int* equation = <int*>writable(equations, np.int32)
        cdef double* factor = <double*>writable(factors, np.float64)
        cdef int count, size = len(unknowns)
        cdef double remainder
        with nogil:
            count = self.dependency_into(size, at, value, equation, factor, &remainder)
        return Dependency(equations[:count].copy(), factors[:count].copy(), remainder)

    def least_norm(self, right):
        """d of least norm with `J d = right` on the independent equations.

        Parameters
        ----------
        right : (m,) or (k, m) float64

        Returns
        -------
        (n,) or (k, n) float64
            The norm is that of `d / scale`, with the scales of the unknowns.
        """
        rights = np.array(right, dtype=np.float64, order="C", ndmin=2)
        if rights.shape[1:] != (self.m,):
            raise ValueError(f"expected right-hand sides of {self.m} numbers, found {rights.shape}")
        for i, (equations, factors) in self._settle().swapped.items():
            scales = self.scales[0]
            rights[:, i] = (rights[:, equations] * scales[equations]) @ factors / scales[i]
        made = np.empty((len(rights), self.n))
        cdef const double* r = <const double*>address(rights, np.float64)
        cdef double* d = <double*>writable(made, np.float64)
        cdef Py_ssize_t k, count = len(rights)
        with nogil:
            for k in range(count):
                self.least_norm_into(r + k * self.m, d + k * self.n)
        return made[0] if np.ndim(right) == 1 else made

    def null_vectors(self):
        """Vectors that span the null space of J, each of as few unknowns as its front reads.

        Returns
        -------
        Vectors
            n - rank vectors of length n, orthonormal when divided by the scales of the unknowns.
        """
        self._require()
        cdef int s, u, i, count, k = 0
        cdef int64_t size = 0, room = 0
        starts = np.zeros(self.nullity + 1, dtype=np.int64)
        places, values = np.empty(0, np.int32), np.empty(0)
        cdef int* place = NULL
        cdef double* value = NULL
        for s in range(self.n + self.copies):
            if not self.part.free[s]:
                continue
            self._look()
            count = self.part.spread(s)
            if size + count > room:
                room = 2 * room + count + self.n
                places, values = np.resize(places, room), np.resize(values, room)
                place = <int*>writable(places, np.int32)
                value = <double*>writable(values, np.float64)
            for i in range(count):
                u = self.part.reached[i]
                if u < self.n:
                    place[size] = u
                    value[size] = self.part.work[u] * self.of_unknowns[u] * self.share[u]
                    size += 1
                self.part.work[u] = 0
            k += 1
            starts[k] = size
        return Vectors(self.n, starts, places[:size].copy(), values[:size].copy())


def _doubles(values, Py_ssize_t count, what):
    made = np.ascontiguousarray(values, dtype=np.float64)
    if made.shape != (count,):
        raise ValueError(f"expected {count} {what}, found shape {made.shape}")
    return made


def _check(m, n, indptr, indices, priority):
    """Raise ValueError for arrays that are not the pattern of an (m, n) matrix."""
    if indptr.shape != (m + 1,) or indptr[0] != 0 or (np.diff(indptr) < 0).any():
        raise ValueError(f"indptr is not an ascending array of {m + 1} places that begins with 0")
    if indices.shape != (indptr[m],):
        raise ValueError(f"expected {indptr[m]} indices, found shape {indices.shape}")
    if len(indices) and not (0 <= indices.min() and indices.max() < n):
        raise ValueError(f"expected indices from 0 to {n - 1}, found {indices.min()} "
                         f"to {indices.max()}")
    if priority.shape != (m,):
        raise ValueError(f"expected {m} priorities, found shape {priority.shape}")
