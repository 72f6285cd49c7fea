"""Sparse L D L' of J J' by components, made row by row from J itself.

The up-looking method of T. Davis, "Algorithm 849", ACM TOMS 31 (2005). Rows of J have unit length,
so a pivot is the squared sine of the angle between a row and the span of the rows before it: one
that vanishes belongs to a redundant equation, which is left out of the basis.
"""

import numpy as np

from libc.math cimport sqrt
from libc.stdint cimport int32_t, uint8_t

from arael.runtime.address cimport address, writable
from arael.runtime.compiled cimport Interruption


cdef class RowFactor:
    """Numeric factor on a `Structure`; used from C."""

    def __init__(self, Py_ssize_t n, Py_ssize_t m, structure, scales, basic, double tolerance,
                 double shortest=0.0):
        self.n, self.m = n, m
        self.interruption = Interruption()
        self.count = len(structure.row_of)
        self.components = len(structure.component_start) - 1
        self.pivot_tolerance = tolerance
        self.least_square = max(shortest * shortest, 1e-300)
        entries, count = len(structure.unknown), self.count
        own = {
            "scale": np.array(scales, dtype=np.float64),
            "row_scale": np.zeros(count),
            "value": np.zeros(entries),
            "factor_value": np.zeros(len(structure.factor_row)),
            "inverse": np.zeros(count),
            "work": np.zeros(count),
            "solution": np.zeros(count),
            "filled": np.zeros(count, np.int32),
            "basic": np.ones(count, np.uint8),
        }
        if basic is not None:
            own["basic"][:] = basic[structure.row_of]
        self._keep = structure, own
        self.row_of = <const int32_t*>address(structure.row_of, np.int32)
        self.start = <const int32_t*>address(structure.start, np.int32)
        self.unknown = <const int32_t*>address(structure.unknown, np.int32)
        self.source = <const int32_t*>address(structure.source, np.int32)
        self.column_start = <const int32_t*>address(structure.column_start, np.int32)
        self.column_position = <const int32_t*>address(structure.column_position, np.int32)
        self.column_entry = <const int32_t*>address(structure.column_entry, np.int32)
        self.component_start = <const int32_t*>address(structure.component_start, np.int32)
        self.unknown_start = <const int32_t*>address(structure.unknown_start, np.int32)
        self.unknown_list = <const int32_t*>address(structure.unknown_list, np.int32)
        self.component_of = <const int32_t*>address(structure.component_of, np.int32)
        self.factor_start = <const int32_t*>address(structure.factor_start, np.int32)
        self.factor_row = <const int32_t*>address(structure.factor_row, np.int32)
        self.pattern_start = <const int32_t*>address(structure.pattern_start, np.int32)
        self.pattern_column = <const int32_t*>address(structure.pattern_column, np.int32)
        self.scale = <double*>writable(own["scale"], np.float64)
        self.row_scale = <double*>writable(own["row_scale"], np.float64)
        self.value = <double*>writable(own["value"], np.float64)
        self.factor_value = <double*>writable(own["factor_value"], np.float64)
        self.inverse = <double*>writable(own["inverse"], np.float64)
        self.work = <double*>writable(own["work"], np.float64)
        self.solution = <double*>writable(own["solution"], np.float64)
        self.filled = <int32_t*>writable(own["filled"], np.int32)
        self.basic = <uint8_t*>writable(own["basic"], np.uint8)

    @property
    def structure(self):
        """The analysis that the factor is laid out by."""
        return self._keep[0]

    def dropped(self):
        """Rows without a pivot in the last factors, ascending."""
        return np.sort(self._keep[0].row_of[self._keep[1]["inverse"] == 0.0])

    cdef void load(self, Py_ssize_t c, const double* entries) noexcept nogil:
        cdef Py_ssize_t k, e
        cdef double v, norm
        for k in range(self.component_start[c], self.component_start[c + 1]):
            norm = 0.0
            for e in range(self.start[k], self.start[k + 1]):
                v = entries[self.source[e]] * self.scale[self.unknown[e]]
                self.value[e] = v
                norm += v * v
            norm = 1.0 / sqrt(norm) if norm > self.least_square else 0.0
            self.row_scale[k] = norm
            for e in range(self.start[k], self.start[k + 1]):
                self.value[e] *= norm

    cdef Py_ssize_t factor(self, Py_ssize_t c, double mu) noexcept nogil:
        cdef Py_ssize_t k, e, t, q, p, dropped = 0
        cdef int32_t i
        cdef double v, d, y, part
        cdef double* work = self.work
        cdef double* lower = self.factor_value
        cdef const int32_t* row = self.factor_row
        cdef double least, smallest = 0.0, added = 0.0
        if mu > 0.0:            # the same for all rows before they were scaled
            for k in range(self.component_start[c], self.component_start[c + 1]):
                if self.row_scale[k] > 0 and (smallest == 0 or self.row_scale[k] < smallest):
                    smallest = self.row_scale[k]
        for k in range(self.component_start[c], self.component_start[c + 1]):
            if self.interruption.look():    # `work` is zero here
                return -1
            self.filled[k] = self.factor_start[k]
            for e in range(self.start[k], self.start[k + 1]):
                v = self.value[e]
                if v == 0.0:
                    continue
                t = self.column_start[self.unknown[e]]
                while self.column_position[t] < k:
                    work[self.column_position[t]] += v * self.value[self.column_entry[t]]
                    t += 1
            if mu > 0.0 and smallest > 0.0:
                added = mu * (self.row_scale[k] / smallest) * (self.row_scale[k] / smallest)
            d = 1.0 + added if self.row_scale[k] > 0 else 0.0
            least = max(self.pivot_tolerance, 0.5 * added)
            for p in range(self.pattern_start[k], self.pattern_start[k + 1]):
                i = self.pattern_column[p]
                y = work[i]
                work[i] = 0.0
                q = self.filled[i]
                part = y * self.inverse[i]
                lower[q] = part
                if part != 0.0:
                    d -= part * y
                    for t in range(self.factor_start[i], q):
                        work[row[t]] -= lower[t] * y
                self.filled[i] = <int32_t>(q + 1)
            if self.basic[k] and d > least:
                self.inverse[k] = 1.0 / d
            else:
                self.inverse[k] = 0.0
                dropped += 1
        return dropped

    cdef void solve(self, Py_ssize_t c) noexcept nogil:
        cdef Py_ssize_t k, t, first = self.component_start[c], end = self.component_start[c + 1]
        cdef double* b = self.solution
        cdef const double* lower = self.factor_value
        cdef double z
        for k in range(first, end):
            z = b[k]
            if z != 0.0:
                for t in range(self.factor_start[k], self.factor_start[k + 1]):
                    b[self.factor_row[t]] -= lower[t] * z
        for k in range(end - 1, first - 1, -1):
            z = b[k] * self.inverse[k]
            for t in range(self.factor_start[k], self.factor_start[k + 1]):
                z -= lower[t] * b[self.factor_row[t]]
            b[k] = z

    cdef void step(self, Py_ssize_t c, const double* r, double* d) noexcept nogil:
        cdef Py_ssize_t k, e
        cdef double y
        for k in range(self.component_start[c], self.component_start[c + 1]):
            self.solution[k] = self.row_scale[k] * r[self.row_of[k]]
        self.solve(c)
        for k in range(self.unknown_start[c], self.unknown_start[c + 1]):
            d[self.unknown_list[k]] = 0.0
        for k in range(self.component_start[c], self.component_start[c + 1]):
            y = self.solution[k]
            for e in range(self.start[k], self.start[k + 1]):
                d[self.unknown[e]] -= self.value[e] * y
        for k in range(self.unknown_start[c], self.unknown_start[c + 1]):
            d[self.unknown_list[k]] *= self.scale[self.unknown_list[k]]

    cdef double reduce(self, Py_ssize_t c, double* v) noexcept nogil:
        cdef Py_ssize_t k, e
        cdef double y, taken = 0.0
        for k in range(self.component_start[c], self.component_start[c + 1]):
            y = 0.0
            for e in range(self.start[k], self.start[k + 1]):
                y += self.value[e] * v[self.unknown[e]]
            self.solution[k] = self.work[k] = y
        self.solve(c)
        for k in range(self.component_start[c], self.component_start[c + 1]):
            y = self.solution[k]
            taken += y * self.work[k]
            self.work[k] = 0.0
            for e in range(self.start[k], self.start[k + 1]):
                v[self.unknown[e]] -= self.value[e] * y
        return taken

    cdef void project(self, Py_ssize_t c, double* v) noexcept nogil:
        # Further passes remove what the normal equations left (Bjorck's correction): one in
        # general, more where the rows are close to dependent.
        cdef Py_ssize_t k, t
        cdef double whole = 0.0, taken, before = 0.0
        for k in range(self.unknown_start[c], self.unknown_start[c + 1]):
            whole += v[self.unknown_list[k]] * v[self.unknown_list[k]]
        for t in range(6):
            taken = self.reduce(c, v)
            if taken <= 1e-26 * whole or (t > 0 and not taken <= 0.25 * before):
                return
            before = taken
