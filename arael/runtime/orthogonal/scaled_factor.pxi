"""Factor of a scaled sparse matrix, and solves with it, without the GIL."""

import numpy as np

from libc.math cimport fabs, sqrt
from libc.stdint cimport int64_t
from libc.string cimport memcpy, memset

from arael.runtime.address cimport writable
from arael.runtime.compiled cimport Interruption
from arael.runtime.orthogonal.sorting cimport sort

from arael.runtime.orthogonal.copies import with_copies

NEGLIGIBLE = 1e-10

# What is left of a column within a front, up to which it is taken as zero there.
cdef double NOISE = 64 * 2.220446049250313e-16


cdef class ScaledFactor:
    """J' = Q R of an m by n matrix J, whose equations and unknowns are scaled first.

    Parameters
    ----------
    m, n : int
    indptr, indices : (m + 1,) and (entries,) int32
        A pattern in compressed sparse rows, checked; the arrays are kept.
    tolerance : float
        See `RankQR`.
    interruption : Interruption, optional
        See `RankQR`.
    """

    def __init__(
        self, int m, int n, indptr, indices, double tolerance, Interruption interruption=None
    ):
        self.m, self.n, self.tolerance, self.kept = m, n, tolerance, []
        self.indptr, self.indices = indptr, indices
        starts, places, origins, shares = with_copies(n, indptr, indices)
        self.copies = len(origins) - n
        self.analysis = Analysis(m + self.copies, n + self.copies, starts, places, interruption)
        self.part = Factor(self.analysis)
        self.factored = False
        self.kept += [starts, places, origins, shares]
        self.start = <int*>writable(starts, np.int32)
        self.at = <int*>writable(indices, np.int32)
        self.copy_at = <int*>writable(places, np.int32)
        self.origin = <int*>writable(origins, np.int32)
        self.share = <double*>writable(shares, np.float64)
        self.wide = <double*>self.array(np.float64, n + self.copies)
        self.numbers = np.zeros(len(indices))
        self.entries = <double*>writable(self.numbers, np.float64)
        self.of_equations = <double*>self.array(np.float64, m)
        self.of_unknowns = <double*>self.array(np.float64, n)
        self.least = <double*>self.array(np.float64, m)
        self.side = <double*>self.array(np.float64, n)
        self.other = <double*>self.array(np.float64, n)

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL:
        made = np.zeros(max(count, 1), dtype=dtype)
        self.kept.append(made)
        return writable(made, dtype)

    cdef int factor_entries(self, const double* entries, const double* scale) noexcept nogil:
        cdef int wrong = not_finite(self.m, self.start, entries)
        self.factored = False
        if wrong:
            return wrong
        memcpy(self.entries, entries, self.start[self.m] * sizeof(double))
        self.automatic = scale == NULL
        if self.automatic:
            both_scales(
                self.m, self.n, self.start, self.at, self.entries,
                self.of_unknowns, self.of_equations, self.side, self.other, self.shortest,
            )
        else:
            memcpy(self.of_unknowns, scale, self.n * sizeof(double))
            equation_scales(
                self.m, self.start, self.at, self.entries,
                self.of_unknowns, self.of_equations, self.shortest,
            )
        self.load()
        # Roundings of what is below the pivots of a front; and what counts as no rank.
        if not self.part.factor(self.dead, min(self.dead, NOISE)):
            return -1
        self.factored = True
        return 0

    cdef void load(self) noexcept nogil:
        """Scaled entries for the factorisation, and the absolute tolerance."""
        cdef int i, p, t
        cdef double total, of_unknown, x, greatest = 1.0 if self.shortest > 0 else 0.0
        cdef double* by_entry = self.part.values
        cdef const Plan* a = &self.analysis.plan
        for i in range(self.m):
            self.least[i] = 0
            if self.of_equations[i] == 0:
                continue
            if self.automatic:
                self.least[i] = negligible(
                    self.start[i + 1] - self.start[i], self.entries + self.start[i]
                )
            total = 0
            for p in range(self.start[i], self.start[i + 1]):
                x = self.entries[p] * self.of_unknowns[self.at[p]] * self.of_equations[i]
                total += x * x
            greatest = max(greatest, sqrt(total))
        self.dead = self.tolerance * greatest
        # In the order of unknowns; the scale of the equation last, its product is of order 1.
        for i in range(self.n + self.copies):
            of_unknown = self.of_unknowns[self.origin[i]] * self.share[i]
            for t in range(a.by_unknown[i], a.by_unknown[i + 1]):
                p = a.source[t]
                if a.equation[t] >= self.m:     # equal copies: 1 for one, -1 for the other
                    by_entry[t] = 1.0 if (p - self.start[self.m]) % 2 else -1.0
                    continue
                by_entry[t] = (
                    self.entries[p] * of_unknown * self.of_equations[a.equation[t]]
                    if fabs(self.entries[p]) > self.least[a.equation[t]] else 0.0
                )

    cdef void least_norm_into(self, const double* right, double* d) noexcept nogil:
        cdef const Plan* a = &self.analysis.plan
        cdef int i, f
        for i in range(self.m):
            self.part.multiplier[a.position[i]] = right[i] * self.of_equations[i]
        memset(self.wide, 0, (self.n + self.copies) * sizeof(double))
        self.part.solve_up(self.part.multiplier, self.wide)
        memset(self.part.multiplier, 0, (self.m + self.copies) * sizeof(double))
        for f in range(a.fronts - 1, -1, -1):
            self.part.backward(f, self.wide)
        for i in range(self.n):
            d[i] = self.wide[i] * self.of_unknowns[i] * self.share[i]

    cdef int dependency_into(
        self, int count, const int* unknowns, const double* values, int* equations,
        double* factors, double* remainder,
    ) noexcept nogil:
        cdef const Plan* a = &self.analysis.plan
        cdef double none = 0, length = 0, largest = 0, left = 0, x, y
        cdef double* work = self.part.work
        cdef int p, u, f, i, k, path = 0, visited, found = 0
        cdef int64_t s, begin
        remainder[0] = 0
        if self.automatic:
            none = negligible(count, values)
        for p in range(count):
            if fabs(values[p]) > none:
                x = self.of_unknowns[self.origin[unknowns[p]]]
                largest = max(largest, fabs(values[p] * x))
        if largest == 0:
            return 0
        for p in range(count):
            if fabs(values[p]) > none:
                u = unknowns[p]
                # Of its copies the first: equal ones are what the others' equations are for.
                x = values[p] * self.of_unknowns[self.origin[u]] / largest
                y = work[u] / self.share[u]
                length += (x + y) * (x + y) - y * y
                work[u] = (x + y) * self.share[u]
                path = self.part.climb(a.front_of_unknown[u], path)
        for p in range(count):
            u = unknowns[p]
            if a.front_of_unknown[u] < 0:
                left += self.part.work[u] * self.part.work[u]
                self.part.work[u] = 0
        sort(self.part.path, path)
        for i in range(path):
            self.part.forward(self.part.path[i], self.part.work)
        for i in range(path):
            f = self.part.path[i]
            begin = a.first_row[f]
            for s in range(begin + self.part.reduced[f], begin + self.part.height[f]):
                x = work[self.part.slot[s]]
                left += x * x
        visited = self.part.solve_down(path, self.part.multiplier)
        for i in range(path):
            f = self.part.path[i]
            for s in range(a.first_row[f], a.first_row[f] + self.part.height[f]):
                self.part.work[self.part.slot[s]] = 0
        self.part.release(path)
        x = 0
        for i in range(visited):
            f = self.part.found[i]
            for s in range(a.columns[f], a.columns[f] + a.pivots[f]):
                if a.at[a.column[s]] < self.m:
                    x = max(x, fabs(self.part.multiplier[a.column[s]]))
        x *= NEGLIGIBLE
        for i in range(visited):
            f = self.part.found[i]
            for s in range(a.columns[f], a.columns[f] + a.pivots[f]):
                k = a.column[s]
                if a.at[k] < self.m and fabs(self.part.multiplier[k]) > x:
                    equations[found] = a.at[k]
                    found += 1
        sort(equations, found)
        for i in range(found):
            factors[i] = (
                self.part.multiplier[a.position[equations[i]]]
                * self.of_equations[equations[i]] * largest
            )
        for i in range(visited):
            f = self.part.found[i]
            for s in range(a.columns[f], a.columns[f] + a.pivots[f]):
                self.part.multiplier[a.column[s]] = 0
        if length > 0:
            # Relative to the row, or to what it could be; in units of `largest`.
            y = sqrt(length)
            remainder[0] = min(sqrt(left) / max(y, self.shortest / largest), 1.0)
        return found
