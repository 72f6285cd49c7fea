"""Rows of groups and of bounds as one sparse matrix: values, products, second derivatives."""

import numpy as np

from libc.math cimport fabs, sqrt
from libc.stdint cimport int64_t, uint8_t
from libc.string cimport memcpy, memset

from arael.runtime.address cimport address, writable
from arael.runtime.evaluation.compiled cimport Evaluation, EntityStates, StatePair

# Steps of the differences of Jacobians, relative to the size of a scalar: the square root of the
# noise of a Jacobian of a few operations, which balances rounding against the third derivative.
cdef double DIFFERENCE_STEP = 1e-6
cdef double DIFFERENCE_STEP_F32 = 3e-3
# Scalars smaller than this are moved as if they were this large.
cdef double LEAST_SIZE = 1e-2


# Where a group's rows are.
cdef struct RowGroup:
    int64_t number               # of the group
    int64_t instances
    int64_t residuals            # of an instance
    int64_t entries              # of its Jacobian
    int64_t first_value          # in the values as kernels leave them
    int64_t first_entry          # in the entries as kernels leave them


# One product of two entries of a row, and its place in the values of the blocks.
cdef struct Product:
    int64_t p
    int64_t q
    int64_t place


# What a difference adds to: the change of `entry` when the column of `moved` moves.
cdef struct Difference:
    int64_t entry
    int64_t moved
    int64_t place
    double share


cdef int64_t block_place(
    int64_t high, int64_t low, const int64_t* block_of, const int64_t* offsets,
    const int64_t* column_start, const int64_t* block_row, const int64_t* value_start
) noexcept nogil:
    """Place of a scalar of the lower triangle in the values of the blocks; -1 if it has none."""
    cdef int64_t row = block_of[high], column = block_of[low]
    cdef int64_t first = column_start[column], last = column_start[column + 1], middle
    while first < last:
        middle = (first + last) // 2
        if block_row[middle] < row:
            first = middle + 1
        else:
            last = middle
    if first == column_start[column + 1] or block_row[first] != row:
        return -1
    return (
        value_start[first] + (high - offsets[row]) * (offsets[column + 1] - offsets[column])
        + low - offsets[column])


cdef class RowTable:
    """Residuals of chosen groups, then bounds, as rows of one sparse matrix.

    Entries of scalars that are held are left out. A row may have several entries in one column,
    where two ways lead to the same parameter.

    Parameters
    ----------
    evaluation : Evaluation
    structure : Structure
    groups : list of (number, residuals, jacobian (entries, 3), equal, curved)
    bounds : (scalar, entity, at, sign, limit), arrays (bounds,)

    Attributes
    ----------
    count : int
        Number of rows, those of the groups first.
    group_rows : int
    row, column : (entries,) int64
        Of each entry, by rows.
    equal : (count,) uint8
        Whether a row is an equality.
    """

    cdef readonly Py_ssize_t count, group_rows, entries, size, value_count
    cdef readonly object row, column, equal
    cdef readonly bint is_curved         # whether some row has second derivatives
    cdef readonly Py_ssize_t colours     # evaluations that its second derivatives take
    cdef Evaluation evaluation
    cdef StatePair states
    cdef Py_ssize_t _entities
    cdef object _keep
    cdef const int64_t* _row
    cdef const int64_t* _column
    cdef const uint8_t* _equal
    cdef const uint8_t* still            # [size] scalars that are held
    cdef const int64_t* diagonal_at      # [size] in the values of the blocks
    cdef const int64_t* _start           # [count + 1] first entry of each row
    cdef const int64_t* _value_at        # [group rows] in the values as kernels leave them
    cdef const int64_t* _entry_at        # [entries of groups] likewise
    cdef RowGroup* _groups
    cdef Py_ssize_t _group_count, _group_entries
    cdef void* _raw_values
    cdef void* _raw_entries
    cdef size_t _raw_value_bytes, _raw_entry_bytes
    cdef Product* _products
    cdef Py_ssize_t _product_count
    cdef const int64_t* _bound           # [bounds][2] entity, offset in its states
    cdef const double* _sign
    cdef const double* _limit
    cdef Py_ssize_t _blocks
    cdef const int64_t* _offsets
    cdef const int64_t* _column_start
    cdef const int64_t* _block_row
    cdef const int64_t* _value_start
    cdef Difference* _differences
    cdef const int64_t* _difference_start  # [colours + 1]
    cdef const int64_t* _moved           # columns, by colour
    cdef const int64_t* _moved_start     # [colours + 1]
    cdef void* _step                     # [size] in the precision of the problem
    cdef double _relative_step
    cdef double* _moved_entries          # [entries]
    cdef double* _moved_values           # [count]
    cdef double* _wide_step              # [size]

    def __init__(self, Evaluation evaluation, structure, groups, bounds):
        cdef const int64_t* jacobian
        cdef const int64_t* gradient_at
        cdef const int64_t* lane
        cdef const uint8_t* still
        cdef int64_t[::1] start, cursor, value_at, row, column, entry_at
        cdef RowGroup* one
        cdef int64_t i, e, r, c, k, first_row, uses, n_entries
        cdef int64_t values = 0, raw_entries = 0
        system, pattern = structure.system, structure.pattern
        self.evaluation, self.states = evaluation, evaluation.states
        self.size, self.value_count = system.size, pattern.value_count
        self._keep, self._entities = [], len(evaluation.states.arrays[0])
        self._group_count = len(groups)
        self._groups = <RowGroup*>self._zeros(len(groups) * sizeof(RowGroup))
        held = np.zeros(self.size + structure.trash, dtype=np.uint8)
        held[system.held] = 1
        held[self.size:] = 1
        self._keep.append(held)
        still = self.still = <const uint8_t*>address(held, np.uint8)
        tables = []
        for k, (number, residuals, table, _, _) in enumerate(groups):
            one = &self._groups[k]
            one.number, one.residuals, one.entries = number, residuals, len(table)
            one.instances = len(structure.active[number])
            one.first_value, one.first_entry = values, raw_entries
            values += one.instances * one.residuals
            raw_entries += one.instances * one.entries
            at = np.ascontiguousarray(structure.placements[number].gradient_at, dtype=np.int64)
            order = evaluation.orders[number]
            if order is not None:
                inverse = np.empty(len(order), dtype=np.int64)
                inverse[order] = np.arange(len(order))
                order = inverse
            tables.append((table, at, order))
        self.group_rows, self.count = values, values + len(bounds[0])
        # Entries are counted, then put by rows.
        starts = np.zeros(self.count + 1, dtype=np.int64)
        value_places = np.zeros(self.group_rows, dtype=np.int64)
        start, value_at = starts, value_places
        first_row = 0
        for filling in range(2):
            if filling:
                np.cumsum(starts, out=starts)
                n_entries = starts[self.group_rows]
                self.entries = n_entries + len(bounds[0])
                self._group_entries = n_entries
                self.row = np.empty(self.entries, dtype=np.int64)
                self.column = np.empty(self.entries, dtype=np.int64)
                entry_places = np.empty(n_entries, dtype=np.int64)
                row, column, entry_at = self.row, self.column, entry_places
                cursor = starts[: self.count].copy()
            first_row = 0
            for k, (table, at, order) in enumerate(tables):
                one = &self._groups[k]
                jacobian = <const int64_t*>address(table, np.int64)
                gradient_at = <const int64_t*>address(at, np.int64)
                uses = at.shape[1]
                lane = NULL if order is None else <const int64_t*>address(order, np.int64)
                for i in range(one.instances):
                    for e in range(one.entries):
                        r = first_row + i * one.residuals + jacobian[3 * e]
                        c = gradient_at[i * uses + jacobian[3 * e + 1]] + jacobian[3 * e + 2]
                        if still[c]:
                            continue
                        if not filling:
                            start[r + 1] += 1
                            continue
                        row[cursor[r]], column[cursor[r]] = r, c
                        entry_at[cursor[r]] = (
                            one.first_entry + (i if lane == NULL else lane[i]) * one.entries + e)
                        cursor[r] += 1
                    if filling:
                        for r in range(one.residuals):
                            value_at[first_row + i * one.residuals + r] = (
                                one.first_value
                                + (i if lane == NULL else lane[i]) * one.residuals + r)
                first_row += one.instances * one.residuals
            if not filling:
                starts[self.group_rows + 1:] = 1
        self.row[n_entries:] = np.arange(self.group_rows, self.count)
        self.column[n_entries:] = bounds[0]
        self.equal = np.zeros(self.count, dtype=np.uint8)
        first_row = 0
        for k, (_, _, _, equal, _) in enumerate(groups):
            one = &self._groups[k]
            if equal:
                self.equal[first_row : first_row + one.instances * one.residuals] = 1
            first_row += one.instances * one.residuals
        places = np.column_stack((bounds[1], bounds[2])).astype(np.int64)
        arrays = [
            starts, value_places, entry_places, self.row, self.column, places,
            np.ascontiguousarray(bounds[3], dtype=np.float64),
            np.ascontiguousarray(bounds[4], dtype=np.float64),
        ]
        self._keep += arrays
        self._start = <const int64_t*>address(starts, np.int64)
        self._value_at = <const int64_t*>address(value_places, np.int64)
        self._entry_at = <const int64_t*>address(entry_places, np.int64)
        self._row = <const int64_t*>address(self.row, np.int64)
        self._column = <const int64_t*>address(self.column, np.int64)
        self._equal = <const uint8_t*>address(self.equal, np.uint8)
        self._bound = <const int64_t*>address(places, np.int64)
        self._sign = <const double*>address(arrays[6], np.float64)
        self._limit = <const double*>address(arrays[7], np.float64)
        self._raw_value_bytes = values * (4 if evaluation.single else 8)
        self._raw_entry_bytes = raw_entries * (4 if evaluation.single else 8)
        self._raw_values = self._zeros(self._raw_value_bytes)
        self._raw_entries = self._zeros(self._raw_entry_bytes)
        self._step = self._zeros(8 * self.size)
        self._relative_step = DIFFERENCE_STEP_F32 if evaluation.single else DIFFERENCE_STEP
        self._wide_step = <double*>self._zeros(8 * self.size)
        self._moved_entries = <double*>self._zeros(8 * self.entries)
        self._moved_values = <double*>self._zeros(8 * self.count)
        self._keep.append(structure.plan.diagonal_at)
        self.diagonal_at = <const int64_t*>address(
            structure.plan.diagonal_at, np.int64, self.size)
        self._take_pattern(pattern)
        self._take_colours([curved for _, _, _, _, curved in groups])

    cdef void* _zeros(self, size_t length) except NULL:
        array = np.zeros(max(length, 8) // 8 + 1, dtype=np.float64)
        self._keep.append(array)
        return writable(array, np.float64)

    cdef _take_pattern(self, pattern):
        """The blocks, and where in them products of two entries of a row are."""
        cdef int64_t r, p, q, at = 0
        cdef const int64_t* block_of
        arrays = [
            np.ascontiguousarray(array, dtype=np.int64)
            for array in (
                pattern.offsets, pattern.column_start, pattern.rows, pattern.value_start,
                np.repeat(np.arange(len(pattern.sizes)), pattern.sizes),
            )
        ]
        self._keep += arrays
        self._blocks = len(pattern.sizes)
        self._offsets = <const int64_t*>address(arrays[0], np.int64, self._blocks + 1)
        self._column_start = <const int64_t*>address(arrays[1], np.int64)
        self._block_row = <const int64_t*>address(arrays[2], np.int64)
        self._value_start = <const int64_t*>address(arrays[3], np.int64)
        block_of = <const int64_t*>address(arrays[4], np.int64)
        for r in range(self.count):
            for p in range(self._start[r], self._start[r + 1]):
                for q in range(self._start[r], self._start[r + 1]):
                    at += self._column[p] >= self._column[q]
        self._products = <Product*>self._zeros(at * sizeof(Product))
        self._product_count = at
        at = 0
        for r in range(self.count):
            for p in range(self._start[r], self._start[r + 1]):
                for q in range(self._start[r], self._start[r + 1]):
                    if self._column[p] < self._column[q]:
                        continue
                    self._products[at].p, self._products[at].q = p, q
                    self._products[at].place = block_place(
                        self._column[p], self._column[q], block_of, self._offsets,
                        self._column_start, self._block_row, self._value_start)
                    if self._products[at].place < 0:
                        raise ValueError("a row couples scalars that the pattern does not")
                    at += 1

    cdef _take_colours(self, curved):
        """Columns that no curved row reads together, by colour, with what differences add to.

        Greedy, in order (A. Curtis, M. Powell, J. Reid, IMA J. Applied Math. 13, 1974).
        """
        cdef uint8_t[::1] chosen = np.zeros(self.count, dtype=np.uint8)
        cdef int64_t[::1] colour, by_column, column_start, mark
        cdef int64_t k, r, c, e, p, q, at, colours = 0, first_row = 0, times
        cdef Product* one
        cdef Difference* difference
        cdef int64_t[::1] counts, moved_counts
        for k in range(self._group_count):
            at = self._groups[k].instances * self._groups[k].residuals
            if curved[k]:
                self.is_curved |= at > 0
                for r in range(first_row, first_row + at):
                    chosen[r] = 1
            first_row += at
        if not self.is_curved:
            return
        order = np.argsort(self.column, kind="stable")
        by_column = order
        column_start = np.searchsorted(self.column[order], np.arange(self.size + 1))
        colours_of = np.full(self.size, -1, dtype=np.int64)
        colour, mark = colours_of, np.full(self.size + 1, -1, dtype=np.int64)
        for c in range(self.size):
            times = 0
            for k in range(column_start[c], column_start[c + 1]):
                r = self._row[by_column[k]]
                if not chosen[r]:
                    continue
                times += 1
                for e in range(self._start[r], self._start[r + 1]):
                    if colour[self._column[e]] >= 0:
                        mark[colour[self._column[e]]] = c
            if times:
                k = 0
                while mark[k] == c:
                    k += 1
                colour[c] = k
                colours = max(colours, k + 1)
        self.colours = colours
        counts = starts = np.zeros(colours + 1, dtype=np.int64)
        moved_counts = moved_starts = np.zeros(colours + 1, dtype=np.int64)
        np.cumsum(np.bincount(colours_of[colours_of >= 0], minlength=colours), out=moved_starts[1:])
        # Scalars without a colour, -1, come first.
        moved = np.argsort(colours_of, kind="stable")[self.size - moved_starts[colours]:].copy()
        # The other entry of a pair changes; half of it where both may be moved.
        for filling in range(2):
            if filling:
                np.cumsum(starts, out=starts)
                self._differences = <Difference*>self._zeros(starts[colours] * sizeof(Difference))
                mark = starts[:colours].copy()
            for k in range(self._product_count):
                one = &self._products[k]
                if not chosen[self._row[one.p]]:
                    continue
                for way in range(1 if self._column[one.p] == self._column[one.q] else 2):
                    p, q = (one.p, one.q) if way == 0 else (one.q, one.p)
                    c = colour[self._column[p]]
                    if not filling:
                        counts[c + 1] += 1
                        continue
                    difference = &self._differences[mark[c]]
                    mark[c] += 1
                    difference.entry, difference.moved = q, self._column[p]
                    difference.place = one.place
                    times = 0
                    for e in range(self._start[self._row[p]], self._start[self._row[p] + 1]):
                        times += self._column[e] == self._column[p]
                    difference.share = (
                        1.0 if self._column[p] == self._column[q] else 0.5) / times
        self._keep += [starts, moved_starts, moved]
        self._difference_start = <const int64_t*>address(starts, np.int64)
        self._moved_start = <const int64_t*>address(moved_starts, np.int64)
        self._moved = <const int64_t*>address(moved, np.int64)

    # --- evaluation, at one of the two states ------------------------------------------------

    cdef void evaluate_at(self, int which, double* values, double* entries) noexcept nogil:
        """Values (count,) and entries (entries,)."""
        cdef Py_ssize_t k
        cdef RowGroup* one
        cdef size_t width = 4 if self.evaluation.single else 8
        cdef const float* narrow
        cdef const double* wide
        cdef const void* state
        memset(self._raw_values, 0, self._raw_value_bytes)
        memset(self._raw_entries, 0, self._raw_entry_bytes)
        for k in range(self._group_count):
            one = &self._groups[k]
            if one.instances == 0:
                continue
            self.evaluation.fill(which, True, one.number)
            self.evaluation.compiled.rows(
                one.number, self.evaluation.lanes.whole(which, one.number),
                <char*>self._raw_values + one.first_value * width,
                <char*>self._raw_entries + one.first_entry * width)
        self.evaluation._checked(0)
        if self.evaluation.single:
            narrow = <const float*>self._raw_values
            for k in range(self.group_rows):
                values[k] = narrow[self._value_at[k]]
            narrow = <const float*>self._raw_entries
            for k in range(self._group_entries):
                entries[k] = narrow[self._entry_at[k]]
        else:
            wide = <const double*>self._raw_values
            for k in range(self.group_rows):
                values[k] = wide[self._value_at[k]]
            wide = <const double*>self._raw_entries
            for k in range(self._group_entries):
                entries[k] = wide[self._entry_at[k]]
        for k in range(self.count - self.group_rows):
            state = self.states.entities[self._bound[2 * k]].state[which]
            values[self.group_rows + k] = self._sign[k] * (
                (<double>(<const float*>state)[self._bound[2 * k + 1]] if self.evaluation.single
                 else (<const double*>state)[self._bound[2 * k + 1]]) - self._limit[k])
            entries[self._group_entries + k] = self._sign[k]

    cdef void move(self, const double* step) noexcept nogil:
        """The other state becomes the accepted one moved by a step."""
        cdef Py_ssize_t k
        if self.evaluation.single:
            for k in range(self.size):
                (<float*>self._step)[k] = <float>step[k]
            self.states.move(self._step, self.evaluation.threads)
        else:
            self.states.move(step, self.evaluation.threads)

    cdef void sizes_of(self, double* sizes) noexcept nogil:
        """(size,) magnitude of plain scalars; 1 for those of rotations and directions."""
        cdef Py_ssize_t e, row, u, k
        cdef const EntityStates* one
        cdef const int* use
        cdef const void* state
        cdef int64_t first, at
        memset(sizes, 0, self.size * sizeof(double))
        for e in range(self._entities):
            one = &self.states.entities[e]
            state = one.state[self.states.current]
            for row in range(one.moving):
                first = one.delta_at[row]
                if first < 0:
                    continue
                for u in range(one.use_count):
                    use = <const int*>one.uses + 4 * u
                    for k in range(use[3]):
                        at = row * one.stride + use[0] + k
                        if use[1] != use[3]:
                            sizes[first + use[2] + k] = 1.0
                        elif self.evaluation.single:
                            sizes[first + use[2] + k] = fabs((<const float*>state)[at])
                        else:
                            sizes[first + use[2] + k] = fabs((<const double*>state)[at])

    # --- products ----------------------------------------------------------------------------

    cdef void product(self, const double* entries, const double* x, double* found) noexcept nogil:
        """Product of the derivatives with a step."""
        cdef Py_ssize_t r, e
        cdef double total
        for r in range(self.count):
            total = 0.0
            for e in range(self._start[r], self._start[r + 1]):
                total += entries[e] * x[self._column[e]]
            found[r] = total

    cdef void add_transposed(
        self, const double* entries, const double* y, double* found
    ) noexcept nogil:
        """Add the product of the transposed derivatives with a vector of rows."""
        cdef Py_ssize_t r, e
        for r in range(self.count):
            if y[r] != 0.0:
                for e in range(self._start[r], self._start[r + 1]):
                    found[self._column[e]] += entries[e] * y[r]

    cdef void lengths_of(
        self, const double* entries, const double* scale, double* found
    ) noexcept nogil:
        """(count,) lengths of the rows, of scalars measured by `scale`, 1 where that is NULL."""
        cdef Py_ssize_t r, e
        cdef double total, x
        for r in range(self.count):
            total = 0.0
            for e in range(self._start[r], self._start[r + 1]):
                x = entries[e] if scale == NULL else entries[e] * scale[self._column[e]]
                total += x * x
            found[r] = sqrt(total)

    cdef void add_squares(
        self, const double* entries, const double* weights, double* values
    ) noexcept nogil:
        """Add A' W A to the values of the blocks."""
        cdef Py_ssize_t k
        cdef Product* one
        cdef double weight
        for k in range(self._product_count):
            one = &self._products[k]
            weight = weights[self._row[one.p]]
            if weight != 0.0:
                values[one.place] += weight * entries[one.p] * entries[one.q]

    cdef void symmetric_product(
        self, const double* values, const double* diagonal, const double* x, double* found
    ) noexcept nogil:
        """Product of a matrix in blocks, its diagonal apart, with a vector."""
        cdef Py_ssize_t b, k, r, c
        cdef int64_t i, j, width
        cdef double value
        for k in range(self.size):
            found[k] = diagonal[k] * x[k]
        for b in range(self._blocks):
            width = self._offsets[b + 1] - self._offsets[b]
            for k in range(self._column_start[b], self._column_start[b + 1]):
                for r in range(
                    self._offsets[self._block_row[k] + 1] - self._offsets[self._block_row[k]]
                ):
                    i = self._offsets[self._block_row[k]] + r
                    for c in range(width):
                        j = self._offsets[b] + c
                        if i > j:
                            value = values[self._value_start[k] + r * width + c]
                            found[i] += value * x[j]
                            found[j] += value * x[i]

    cdef void violations_of(self, const double* values, double* found) noexcept nogil:
        """(count,) by how much each row is violated, not negative."""
        cdef Py_ssize_t r
        for r in range(self.count):
            found[r] = fabs(values[r]) if self._equal[r] else max(0.0, -values[r])

    cdef void add_curvature(
        self, const double* weights, const double* entries, const double* sizes, double* values
    ) noexcept nogil:
        """Add the second derivatives of the rows, each times its weight, at the accepted state.

        From differences of first derivatives, one evaluation for each colour.
        """
        cdef Py_ssize_t colour, k
        cdef Difference* one
        for colour in range(self.colours):
            memset(self._wide_step, 0, self.size * sizeof(double))
            for k in range(self._moved_start[colour], self._moved_start[colour + 1]):
                self._wide_step[self._moved[k]] = (
                    self._relative_step * max(sizes[self._moved[k]], LEAST_SIZE))
            self.move(self._wide_step)
            self.evaluate_at(1 - self.states.current, self._moved_values, self._moved_entries)
            for k in range(self._difference_start[colour], self._difference_start[colour + 1]):
                one = &self._differences[k]
                if weights[self._row[one.entry]] != 0.0:
                    values[one.place] += (
                        weights[self._row[one.entry]] * one.share
                        * (self._moved_entries[one.entry] - entries[one.entry])
                        / self._wide_step[one.moved])

    # --- from Python -------------------------------------------------------------------------

    def evaluate(self):
        """Values (count,) and entries (entries,) at the accepted state."""
        values, entries = np.empty(self.count), np.empty(self.entries)
        cdef double* first = <double*>writable(values, np.float64)
        cdef double* second = <double*>writable(entries, np.float64)
        with nogil:
            self.evaluation.guard()
            self.evaluate_at(self.states.current, first, second)
        self.evaluation.raise_failure()
        return values, entries

    def sizes(self):
        """(size,) magnitude of plain scalars that move; 1 for those of rotations and directions."""
        sizes = np.empty(self.size)
        self.sizes_of(<double*>writable(sizes, np.float64))
        return sizes

    def times(self, entries, x):
        """Product of the derivatives with a step (size,)."""
        found = np.empty(self.count)
        self.product(
            <const double*>address(entries, np.float64, self.entries),
            <const double*>address(x, np.float64, self.size),
            <double*>writable(found, np.float64))
        return found

    def transposed(self, entries, y):
        """Product of the transposed derivatives with a vector of rows (count,)."""
        found = np.zeros(self.size)
        self.add_transposed(
            <const double*>address(entries, np.float64, self.entries),
            <const double*>address(y, np.float64, self.count),
            <double*>writable(found, np.float64))
        return found

    def lengths(self, entries, scale):
        """(count,) lengths of the rows, of scalars measured by `scale` (size,)."""
        found = np.empty(self.count)
        self.lengths_of(
            <const double*>address(entries, np.float64, self.entries),
            <const double*>address(scale, np.float64, self.size),
            <double*>writable(found, np.float64))
        return found

    def squared(self, entries, weights):
        """Values of A' W A in the blocks of the system; weights (count,) by rows."""
        found = np.zeros(self.value_count)
        self.add_squares(
            <const double*>address(entries, np.float64, self.entries),
            <const double*>address(weights, np.float64, self.count),
            <double*>writable(found, np.float64))
        return found

    def curvature(self, weights, entries):
        """Values of the sum of second derivatives of the rows, each times its weight (count,).

        At the accepted state, where `entries` are known.
        """
        found, sizes = np.zeros(self.value_count), self.sizes()
        cdef const double* first = <const double*>address(weights, np.float64, self.count)
        cdef const double* second = <const double*>address(entries, np.float64, self.entries)
        cdef const double* third = <const double*>address(sizes, np.float64)
        cdef double* total = <double*>writable(found, np.float64)
        with nogil:
            self.add_curvature(first, second, third, total)
        self.evaluation.raise_failure()
        return found

    def violations(self, values):
        """(count,) by how much each row is violated, not negative."""
        return np.where(self.equal, np.abs(values), np.maximum(0.0, -values))

    def settle(self, multipliers, tolerance):
        """Put scalars that are held by a bound, or beyond it, exactly on it."""
        cdef Py_ssize_t k, bounds = self.count - self.group_rows
        cdef void* state
        values, _ = self.evaluate()
        held = (multipliers > 0.0) & (np.abs(values) <= tolerance) | (values < 0.0)
        held[: self.group_rows] = False
        if not held.any():
            return
        step = np.zeros(self.size)
        for k in range(bounds):
            if held[self.group_rows + k]:
                step[self.column[self._group_entries + k]] = (
                    -self._sign[k] * values[self.group_rows + k])
        cdef const double* by = <const double*>address(step, np.float64)
        with nogil:
            self.move(by)
        for k in range(bounds):
            if held[self.group_rows + k]:  # without rounding
                state = self.states.entities[self._bound[2 * k]].state[1 - self.states.current]
                if self.evaluation.single:
                    (<float*>state)[self._bound[2 * k + 1]] = <float>self._limit[k]
                else:
                    (<double*>state)[self._bound[2 * k + 1]] = self._limit[k]
        self.states.accept()
        self.evaluation.raise_failure()
