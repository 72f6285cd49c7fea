"""Multifrontal Householder QR of J', with dependent columns skipped, and its use.

Fronts are reduced from the leaves to the roots. A column whose remaining length is below a
tolerance adds no rank; it gets no pivot, and what remained of it is dropped (M. Heath, "Some
extensions of an algorithm for sparse linear least squares problems", SIAM J. Sci. Stat. Comput. 3
(1982); with Householder reflections in fronts: T. Davis, SuiteSparseQR, 2011). Each front is
reduced in all its columns, so it passes a trapezoid to its parent, and rows beyond it end here:
they belong to vectors of the null space of J, which read only unknowns of the subtree.

Q is kept as reflections. They act in place on vectors with one *slot* per unknown.
"""

import numpy as np

from libc.math cimport fabs
from libc.stdint cimport int64_t, uint8_t
from libc.string cimport memset

from arael.runtime.address cimport writable
from arael.runtime.orthogonal.sorting cimport sort

cdef extern from "householder.h":
    void qr_add(Py_ssize_t n, double f, const double* x, double* y) nogil
    double qr_dot(Py_ssize_t n, const double* x, const double* y) nogil
    void qr_reflect(Py_ssize_t n, double tau, const double* v, double* x) nogil
    int qr_reduce(
        int rows, int columns, int pivots, double* a, const int* stair, int* pivot, double* tau,
        double* norms, double dead, double noise,
    ) nogil

# Multipliers and entries of null vectors below this part of the largest are rounding errors: they
# are set to zero, and what they would reach is not visited.
cdef double NOTHING = 16 * 2.220446049250313e-16


cdef class Factor:
    """Numeric factor; `values` are set by the owner before `factor`."""

    def __init__(self, Analysis analysis):
        cdef int m = analysis.plan.m, n = analysis.plan.n, fronts = analysis.plan.fronts
        self.analysis, self.kept = analysis, []
        self.interruption = analysis.interruption
        self.values = <double*>self.array(np.float64, analysis.plan.by_unknown[n])
        self.cell = <double*>self.array(np.float64, analysis.plan.cells)
        self.tau = <double*>self.array(np.float64, analysis.plan.columns[fronts])
        self.pivot = <int*>self.array(np.int32, analysis.plan.columns[fronts])
        self.stair = <int*>self.array(np.int32, analysis.plan.columns[fronts])
        self.slot = <int*>self.array(np.int32, analysis.plan.rows)
        self.lead = <int*>self.array(np.int32, analysis.plan.rows)
        self.height = <int*>self.array(np.int32, fronts)
        self.live = <int*>self.array(np.int32, fronts)
        self.reduced = <int*>self.array(np.int32, fronts)
        self.norms = <double*>self.array(np.float64, m)
        self.slot_of = <int*>self.array(np.int32, m)
        self.front_of_slot = <int*>self.array(np.int32, n)
        self.free = <uint8_t*>self.array(np.uint8, n)
        self.work = <double*>self.array(np.float64, n)
        self.multiplier = <double*>self.array(np.float64, m)
        self.row = <double*>self.array(np.float64, analysis.plan.tallest)
        self.reached = <int*>self.array(np.int32, n)
        self.marked = <uint8_t*>self.array(np.uint8, fronts)
        self.path = <int*>self.array(np.int32, fronts)
        self.found = <int*>self.array(np.int32, fronts)

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL:
        made = np.zeros(max(count, 1), dtype=dtype)
        self.kept.append(made)
        return writable(made, dtype)

    cdef bint factor(self, double dead, double noise) noexcept nogil:
        """Factor `values`; False if it was broken off."""
        cdef int f, u
        for u in range(self.analysis.plan.n):
            self.front_of_slot[u], self.free[u] = -1, 1
        for f in range(self.analysis.plan.fronts):
            if self.interruption.look():
                return False
            self.front(f, dead, noise)
        self.count()
        return True

    cdef void front(self, int f, double dead, double noise) noexcept nogil:
        """Assemble a front from its own rows and those of its children, and reduce it."""
        cdef const Plan* a = &self.analysis.plan
        cdef int64_t first = a.columns[f], s
        cdef int columns = <int>(a.columns[f + 1] - first), pivots = a.pivots[f]
        cdef int* slot = self.slot + a.first_row[f]
        cdef int* lead = self.lead + a.first_row[f]
        cdef int* stair = self.stair + first
        cdef double* cell = self.cell + a.first_cell[f]
        cdef double* from_
        cdef int* up
        cdef int c, i, j, k, t, u, rows = 0, at, tall
        # Rows in the order of their leading columns: count, add up, place.
        memset(stair, 0, columns * sizeof(int))
        for t in range(a.own[f], a.own[f + 1]):
            stair[a.lead[t]] += 1
        c = a.child[f]
        while c >= 0:
            up = a.upward + a.columns[c]
            for i in range(self.live[c], self.reduced[c]):
                stair[up[self.lead[a.first_row[c] + i]]] += 1
            c = a.sibling[c]
        for k in range(columns):
            rows += stair[k]
            stair[k] = rows - stair[k]      # first row of the column, and then the end of its rows
        memset(cell, 0, <size_t>rows * columns * sizeof(double))
        for t in range(a.own[f], a.own[f + 1]):
            u = a.unknown[t]
            at = stair[a.lead[t]]
            stair[a.lead[t]] += 1
            slot[at] = u
            for s in range(a.by_unknown[u], a.by_unknown[u + 1]):
                cell[<int64_t>a.local[s] * rows + at] += self.values[s]
        c = a.child[f]
        while c >= 0:
            up = a.upward + a.columns[c]
            tall = self.height[c]
            for i in range(self.live[c], self.reduced[c]):
                j = self.lead[a.first_row[c] + i]
                at = stair[up[j]]
                stair[up[j]] += 1
                slot[at] = self.slot[a.first_row[c] + i]
                from_ = self.cell + a.first_cell[c] + i
                for k in range(j, <int>(a.columns[c + 1] - a.columns[c])):
                    cell[<int64_t>up[k] * rows + at] = from_[<int64_t>k * tall]
            c = a.sibling[c]
        self.height[f] = rows
        self.reduced[f] = qr_reduce(
            rows, columns, pivots, cell, stair, self.pivot + first, self.tau + first,
            self.norms + a.column[first] if columns else NULL, dead, noise,
        )
        self.live[f] = 0
        for k in range(columns):
            at = self.pivot[first + k]
            if at >= 0:
                lead[at] = k
                self.live[f] += k < pivots
            if k < pivots:
                self.slot_of[a.column[first + k]] = -1 if at < 0 else slot[at]
        for i in range(rows):
            self.front_of_slot[slot[i]] = f
            self.free[slot[i]] = i >= self.live[f]

    cdef void count(self) noexcept nogil:
        """Count the rank; find how far the decisions were from the tolerance."""
        cdef int k
        self.rank = 0
        self.smallest_kept, self.largest_dropped = 1e300, 0.0
        for k in range(self.analysis.plan.m):
            if self.slot_of[k] >= 0:
                self.rank += 1
                self.smallest_kept = min(self.smallest_kept, self.norms[k])
            else:
                self.largest_dropped = max(self.largest_dropped, self.norms[k])

    cdef bint gather(self, int f, const double* v) noexcept nogil:
        """Rows of a front from the slots of v into `row`; whether any is not zero."""
        cdef const int* slot = self.slot + self.analysis.plan.first_row[f]
        cdef int i
        cdef bint any_ = False
        for i in range(self.height[f]):
            self.row[i] = v[slot[i]]
            any_ |= self.row[i] != 0
        return any_

    cdef void forward(self, int f, double* v) noexcept nogil:
        """v = Q_f' v."""
        cdef const Plan* a = &self.analysis.plan
        cdef int64_t first = a.columns[f]
        cdef int columns = <int>(a.columns[f + 1] - first), rows = self.height[f]
        cdef int k, i, top = 0
        cdef const int* slot = self.slot + a.first_row[f]
        cdef const double* cell = self.cell + a.first_cell[f]
        if not self.gather(f, v):
            return
        for k in range(columns):
            if self.pivot[first + k] >= 0:
                qr_reflect(
                    self.stair[first + k] - top, self.tau[first + k],
                    cell + <int64_t>k * rows + top + 1, self.row + top,
                )
                top += 1
        for i in range(rows):
            v[slot[i]] = self.row[i]

    cdef bint backward(self, int f, double* v) noexcept nogil:
        """v = Q_f v; False if all of its slots are zero."""
        cdef const Plan* a = &self.analysis.plan
        cdef int64_t first = a.columns[f]
        cdef int columns = <int>(a.columns[f + 1] - first), rows = self.height[f]
        cdef int k, i, top
        cdef const int* slot = self.slot + a.first_row[f]
        cdef const double* cell = self.cell + a.first_cell[f]
        if not self.gather(f, v):
            return False
        for k in range(columns - 1, -1, -1):
            top = self.pivot[first + k]
            if top >= 0:
                qr_reflect(
                    self.stair[first + k] - top, self.tau[first + k],
                    cell + <int64_t>k * rows + top + 1, self.row + top,
                )
        for i in range(rows):
            v[slot[i]] = self.row[i]
        return True

    cdef int climb(self, int f, int count) noexcept nogil:
        """Mark a front and all above it, in `path`; returns the new length of that."""
        while f >= 0 and not self.marked[f]:
            self.marked[f] = 1
            self.path[count] = f
            count += 1
            f = self.analysis.plan.parent[f]
        return count

    cdef void release(self, int count) noexcept nogil:
        """Unmark the fronts of the path."""
        cdef int i
        for i in range(count):
            self.marked[self.path[i]] = 0

    cdef bint reaches(self, int f, const double* x) noexcept nogil:
        """Whether a column that ends above a front has a multiplier."""
        cdef const Plan* a = &self.analysis.plan
        cdef int64_t s
        for s in range(a.columns[f] + a.pivots[f], a.columns[f + 1]):
            if x[a.column[s]] != 0:
                return True
        return False

    cdef void multipliers(self, int f, double* v, double* x, double* largest) noexcept nogil:
        """Back substitution in the rows of a front; v holds the right-hand side, by slot."""
        cdef const Plan* a = &self.analysis.plan
        cdef int64_t first = a.columns[f]
        cdef int columns = <int>(a.columns[f + 1] - first), rows = self.height[f]
        cdef int live = self.live[f], k, i, at
        cdef const int* slot = self.slot + a.first_row[f]
        cdef const double* cell = self.cell + a.first_cell[f]
        cdef double found
        for i in range(live):
            self.row[i] = v[slot[i]]
        for k in range(columns - 1, -1, -1):
            if k >= a.pivots[f]:
                found = x[a.column[first + k]]
                if found != 0:
                    qr_add(live, -found, cell + <int64_t>k * rows, self.row)
                continue
            at = self.pivot[first + k]
            if at < 0:
                continue
            found = self.row[at] / cell[<int64_t>k * rows + at]
            if fabs(found) > largest[0]:
                largest[0] = fabs(found)
            elif fabs(found) <= NOTHING * largest[0]:
                found = 0
            x[a.column[first + k]] = found
            if found != 0:
                qr_add(at, -found, cell + <int64_t>k * rows, self.row)

    cdef int solve_down(self, int count, double* x) noexcept nogil:
        """R x = y for y in `work`, which is zero outside of the marked path of `count` fronts.

        Visits only fronts that the path or a multiplier reaches; returns their number, in `found`.
        """
        cdef const Plan* a = &self.analysis.plan
        cdef int i, c, f, visited = 0, done = 0
        cdef double largest = 0
        for i in range(count):
            if a.parent[self.path[i]] < 0:
                self.found[visited] = self.path[i]
                visited += 1
        while done < visited:
            f = self.found[done]
            done += 1
            self.multipliers(f, self.work, x, &largest)
            c = a.child[f]
            while c >= 0:
                if self.marked[c] or self.reaches(c, x):
                    self.found[visited] = c
                    visited += 1
                c = a.sibling[c]
        return visited

    cdef void solve_up(self, double* x, double* v) noexcept nogil:
        """R' z = x; z goes into the slots of v, and x is overwritten."""
        cdef const Plan* a = &self.analysis.plan
        cdef int f, k, columns, rows, at, live
        cdef int64_t first
        cdef const double* cell
        cdef const int* slot
        cdef double z
        cdef bint any_
        for f in range(a.fronts):
            first, rows, live = a.columns[f], self.height[f], self.live[f]
            columns = <int>(a.columns[f + 1] - first)
            cell = self.cell + a.first_cell[f]
            slot = self.slot + a.first_row[f]
            any_ = False
            for k in range(a.pivots[f]):
                at = self.pivot[first + k]
                if at >= 0:
                    z = x[a.column[first + k]]
                    if any_:
                        z -= qr_dot(at, cell + <int64_t>k * rows, self.row)
                    self.row[at] = z / cell[<int64_t>k * rows + at] if z != 0 else 0.0
                    any_ |= z != 0
            if any_:
                for k in range(a.pivots[f], columns):
                    x[a.column[first + k]] -= qr_dot(live, cell + <int64_t>k * rows, self.row)
            for at in range(live):
                v[slot[at]] = self.row[at] if any_ else 0.0

    cdef int spread(self, int slot) noexcept nogil:
        """Q e_slot in `work`, where it has entries, for a slot without a pivot.

        Visits only fronts that an entry reaches; returns the number of unknowns with an entry,
        which are in `reached`, ascending.
        """
        cdef const Plan* a = &self.analysis.plan
        cdef int f = self.front_of_slot[slot], c, i, u, visited = 0, done = 0, count = 0
        cdef bint any_
        cdef const int* passed
        if f < 0:
            self.work[slot] = 1
            self.reached[0] = slot
            return 1
        self.work[slot] = 1
        self.found[0] = f
        visited = 1
        while done < visited:
            f = self.found[done]
            done += 1
            self.backward(f, self.work)
            c = a.child[f]
            while c >= 0:
                any_ = False
                passed = self.slot + a.first_row[c]
                for i in range(self.live[c], self.reduced[c]):
                    if fabs(self.work[passed[i]]) <= NOTHING:
                        self.work[passed[i]] = 0
                    else:
                        any_ = True
                if any_:
                    self.found[visited] = c
                    visited += 1
                c = a.sibling[c]
        for i in range(visited):
            f = self.found[i]
            for c in range(a.own[f], a.own[f + 1]):
                u = a.unknown[c]
                if fabs(self.work[u]) <= NOTHING:
                    self.work[u] = 0
                else:
                    self.reached[count] = u
                    count += 1
        sort(self.reached, count)
        return count
