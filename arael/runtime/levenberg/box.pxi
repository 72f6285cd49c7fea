"""Bounds of parameters as hard limits of a solve.

Projected Levenberg-Marquardt: scalars that stand at a bound and would be pushed through it are left
out of the linear system; of the others the step is cut off at the bound (Bertsekas, "Projected
Newton methods for optimization problems with simple constraints", SIAM J. Control 20, 1982).
"""

import numpy as np

from cython cimport floating
from libc.math cimport fabs, isfinite
from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.string cimport memset

from arael.runtime.address cimport address, table_address
from arael.runtime.evaluation.compiled cimport Evaluation

from arael.runtime.assembly.positions import row_and_column_positions


# Of a system without bounds.
NOTHING = [np.zeros(int(k == 4), dtype=np.int64) for k in range(6)], [np.zeros(0) for _ in range(2)]


cdef bint unbounded(low, high) except -1:
    """Whether all bounds (n,) are infinite."""
    cdef Py_ssize_t n = len(low), k
    cdef const double* least = <const double*>address(low, np.float64)
    cdef const double* most = <const double*>address(high, np.float64, n)
    for k in range(n):
        if isfinite(least[k]) or isfinite(most[k]):
            return False
    return True


cdef class Box:
    """The bounded scalars of a system.

    Parameters
    ----------
    evaluation : Evaluation
    structure : Structure
    diagonal_at : (n,) int64, offsets of the diagonal in the values
    """

    def __init__(self, Evaluation evaluation, structure, diagonal_at):
        system, pattern = structure.system, structure.pattern
        blocks = pattern.places
        if unbounded(system.low, system.high):
            ints, ends = NOTHING
        else:
            scalars = np.flatnonzero(np.isfinite(system.low) | np.isfinite(system.high))
            entity, at = stored_places(system, scalars)
            start, positions = row_and_column_positions(pattern, scalars)
            ints = [
                np.ascontiguousarray(a, dtype=np.int64)
                for a in (scalars, entity, at, diagonal_at[scalars], start, positions)
            ]
            ends = [np.ascontiguousarray(a[scalars]) for a in (system.low, system.high)]
        self._all = (ints, ends, blocks)
        self._evaluation = evaluation
        self.restrict()

    def restrict(self, component=None, kept=None):
        """Look at the scalars and blocks of some components only.

        Parameters
        ----------
        component : (n,) int32, component of each scalar of the system
        kept : (components,) bool; None: all
        """
        ints, ends, blocks = self._all
        if kept is not None:
            scalars, entity, at, diagonal, start, positions = ints
            chosen = kept[component[scalars]]
            lengths = np.diff(start)
            ints = [
                *(array[chosen] for array in (scalars, entity, at, diagonal)),
                np.concatenate(([0], np.cumsum(lengths[chosen]))),
                positions[np.repeat(chosen, lengths)],
            ]
            ends = [array[chosen] for array in ends]
            blocks = blocks[kept[component[blocks[:, 1]]]]
        self._keep = (ints, ends, blocks)
        self.count = len(ints[0])
        self._scalar = <const int64_t*>address(ints[0], np.int64)
        self._entity = <const int64_t*>address(ints[1], np.int64)
        self._at = <const int64_t*>address(ints[2], np.int64)
        self._diagonal = <const int64_t*>address(ints[3], np.int64)
        self._start = <const int64_t*>address(ints[4], np.int64)
        self._positions = <const int64_t*>address(ints[5], np.int64)
        self._blocks = <const int64_t*>table_address(blocks, 5)
        self._block_count = len(blocks)
        self._low = <const double*>address(ends[0], np.float64, self.count)
        self._high = <const double*>address(ends[1], np.float64, self.count)

    cdef void mark(
        self, const int32_t* component, uint8_t* bounded, Py_ssize_t stride
    ) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self.count):
            bounded[stride * (0 if component == NULL else component[self._scalar[k]])] = True

    cdef double _value(self, Py_ssize_t k) noexcept nogil:
        """Present value of a bounded scalar."""
        cdef void* state = self._evaluation.states.at(self._entity[k])
        if self._evaluation.single:
            return (<float*>state)[self._at[k]]
        return (<double*>state)[self._at[k]]

    cdef void hold(self, void* gradient, void* values) noexcept nogil:
        if self._evaluation.single:
            self._hold(<float*>gradient, <float*>values)
        else:
            self._hold(<double*>gradient, <double*>values)

    cdef void _hold(self, floating* gradient, floating* values) noexcept nogil:
        cdef Py_ssize_t k, p
        cdef double x, slack
        cdef floating g
        for k in range(self.count):
            x = self._value(k)
            g = gradient[self._scalar[k]]
            # A step onto a bound may end a rounding away from it.
            slack = (1e-6 if floating is float else 1e-14) * (1 + fabs(x))
            if (g > 0 and x <= self._low[k] + slack) or (g < 0 and x >= self._high[k] - slack):
                gradient[self._scalar[k]] = 0
                for p in range(self._start[k], self._start[k + 1]):
                    values[self._positions[p]] = 0
                values[self._diagonal[k]] = 1

    cdef bint clamp(self, void* step, const int32_t* component, uint8_t* cut) noexcept nogil:
        if self._evaluation.single:
            return self._clamp(<float*>step, component, cut)
        return self._clamp(<double*>step, component, cut)

    cdef bint _clamp(
        self, floating* step, const int32_t* component, uint8_t* cut
    ) noexcept nogil:
        cdef Py_ssize_t k, i
        cdef double x, s
        cdef bint any_cut = False
        for k in range(self.count):
            i = self._scalar[k]
            x, s = self._value(k), step[i]
            if x + s < self._low[k]:
                step[i] = <floating>(self._low[k] - x)
            elif x + s > self._high[k]:
                step[i] = <floating>(self._high[k] - x)
            else:
                continue
            any_cut = True
            cut[0 if component == NULL else component[i]] = True
        return any_cut

    cdef void curvature(
        self, const void* values, const void* step, const int32_t* component, double* total
    ) noexcept nogil:
        if self._evaluation.single:
            self._curvature(<const float*>values, <const float*>step, component, total)
        else:
            self._curvature(<const double*>values, <const double*>step, component, total)

    cdef void _curvature(
        self, const floating* values, const floating* step, const int32_t* component,
        double* total
    ) noexcept nogil:
        cdef Py_ssize_t b, i, j, c = 0
        cdef const int64_t* block
        cdef const floating* value
        cdef double sum_, row
        for b in range(self._block_count):
            block = &self._blocks[5 * b]
            value = values + block[4]
            if component != NULL:
                c = component[block[0]]
            sum_ = total[c]
            for i in range(block[2]):
                row = 0
                if block[0] == block[1]:
                    for j in range(i):
                        row += 2 * <double>value[i * block[3] + j] * step[block[1] + j]
                    row += <double>value[i * block[3] + i] * step[block[1] + i]
                else:
                    for j in range(block[3]):
                        row += 2 * <double>value[i * block[3] + j] * step[block[1] + j]
                sum_ += row * step[block[0] + i]
            total[c] = sum_

    cdef void product(self, const void* values, const double* x, double* found) noexcept nogil:
        memset(found, 0, self._evaluation.size * sizeof(double))
        if self._evaluation.single:
            self._product(<const float*>values, x, found)
        else:
            self._product(<const double*>values, x, found)

    cdef void _product(
        self, const floating* values, const double* x, double* found
    ) noexcept nogil:
        cdef Py_ssize_t b, i, j, row, column
        cdef const int64_t* block
        cdef const floating* value
        cdef double sum_
        for b in range(self._block_count):
            block = &self._blocks[5 * b]
            row, column = block[0], block[1]
            for i in range(block[2]):
                value = values + block[4] + i * block[3]
                sum_ = 0
                # Of a diagonal block the lower triangle alone is meaningful.
                for j in range(i if row == column else block[3]):
                    sum_ += <double>value[j] * x[column + j]
                    found[column + j] += <double>value[j] * x[row + i]
                if row == column:
                    sum_ += <double>value[i] * x[row + i]
                found[row + i] += sum_


def stored_places(system, scalars):
    """Entity and offset in its state array of the stored scalar behind each plain scalar."""
    entity = np.searchsorted(np.asarray(system.starts), scalars, side="right") - 1
    at = np.zeros(len(scalars), dtype=np.int64)
    for k, (e, scalar) in enumerate(zip(entity, scalars, strict=True)):
        owner = system.layout.entities[e]
        _, row, tangent = system.owner(int(scalar))
        use = next(
            u for u in owner.params
            if u.tangent_start <= tangent < u.tangent_start + u.tangent
        )
        at[k] = row * owner.state + use.stored_start + tangent - use.tangent_start
    return entity, at
