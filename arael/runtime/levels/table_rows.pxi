"""Rows from tables of instances: their memory, their pattern and their evaluation."""

from arael.runtime.levels.growth cimport grown
from libc.math cimport isfinite
from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport free
from libc.string cimport memset


cdef class TableRows(Rows):
    """What `KernelRows` is in a solve: the instances as they are, without the edits.

    Parameters
    ----------
    layout, kernels, n
        See `KernelRows`.
    """

    def __init__(self, layout, kernels=None, Py_ssize_t n=0):
        cdef Py_ssize_t k
        self._expression = []
        self._table = [LaneTable(layout, k, kernels) for k in range(len(layout.groups))]
        self.tables = {table.struct: table for table in self._table}
        if len(self.tables) != len(self._table):
            raise ValueError("expected one constraint per struct")
        self._table_count = len(self._table)
        self._tables = <void**>grown(NULL, self._table_count, sizeof(void*))
        self._arrays = <LaneArrays**>grown(NULL, self._table_count, sizeof(void*))
        for k in range(self._table_count):
            self._tables[k] = <void*>self._table[k]
            self._arrays[k] = &(<LaneTable>self._table[k]).arrays
        self.unknowns = UnknownWindows(
            n, {width for table in self._table for width in table.widths})
        self._reserve_rows(16)
        self._indptr[0] = 0
        self._indices = <int32_t*>grown(NULL, 1, sizeof(int32_t))
        self._capacity = 1

    def __dealloc__(self):
        free(self._tables)
        free(self._arrays)
        free(self._table_of)
        free(self._index_of)
        free(self._shown)
        free(self._quantity)
        free(self._expression_of)
        free(self._term_of)
        free(self._expressions)
        free(self._expression_at)
        free(self._terms)
        free(self._indptr)
        free(self._indices)
        free(self._mark)
        free(self._slot)

    # ---- memory --------------------------------------------------------------------------------

    cdef _reserve_rows(self, Py_ssize_t count):
        cdef Py_ssize_t capacity = max(count, 2 * self._row_capacity)
        if count <= self._row_capacity:
            return
        self._table_of = <int32_t*>grown(self._table_of, capacity, sizeof(int32_t))
        self._index_of = <int32_t*>grown(self._index_of, capacity, sizeof(int32_t))
        self._shown = <uint8_t*>grown(self._shown, capacity, 1)
        self._quantity = <uint8_t*>grown(self._quantity, capacity, 1)
        self._expression_of = <int32_t*>grown(self._expression_of, capacity, sizeof(int32_t))
        self._term_of = <int32_t*>grown(self._term_of, capacity, sizeof(int32_t))
        self._indptr = <int32_t*>grown(self._indptr, capacity + 1, sizeof(int32_t))
        self._row_capacity = capacity
        self.indptr = self._indptr

    cdef _reserve_marks(self, Py_ssize_t n):
        """Memory for the pattern of rows with so many unknowns."""
        cdef Py_ssize_t count = max(n, 2 * self._mark_capacity)
        if n <= self._mark_capacity:
            return
        self._mark = <int64_t*>grown(self._mark, count, sizeof(int64_t))
        self._slot = <int32_t*>grown(self._slot, count, sizeof(int32_t))
        memset(self._mark + self._mark_capacity, 0,
               (count - self._mark_capacity) * sizeof(int64_t))
        self._mark_capacity = count

    # ---- rows ----------------------------------------------------------------------------------

    cdef LaneTable _table_at(self, Py_ssize_t row):
        if not 0 <= row < self.m or self._table_of[row] < 0:
            raise ValueError(f"no instance begins at row {row}")
        return <LaneTable>self._tables[self._table_of[row]]

    cdef void _activate(self, Py_ssize_t row, bint on) noexcept nogil:
        """Let an instance be evaluated, or not; the pattern is out of date then."""
        cdef LaneArrays* table = self._arrays[self._table_of[row]]
        cdef Py_ssize_t i = self._index_of[row], other
        if on and i >= table.active:
            other = table.active
            (<LaneTable>self._tables[self._table_of[row]]).set_active(table.active + 1)
        elif not on and i < table.active:
            other = table.active - 1
            (<LaneTable>self._tables[self._table_of[row]]).set_active(other)
        else:
            other = i
        (<LaneTable>self._tables[self._table_of[row]]).swap(i, other)
        self._index_of[table.first[i]] = <int32_t>i
        self._index_of[table.first[other]] = <int32_t>other
        self._show(row, on and not self._quantity[row])

    cdef void _show(self, Py_ssize_t row, bint on) noexcept nogil:
        cdef LaneArrays* table = self._arrays[self._table_of[row]]
        cdef Py_ssize_t k
        for k in range(row, row + table.residuals):
            self._shown[k] = on

    # ---- the pattern ---------------------------------------------------------------------------

    cdef _touch(self, Py_ssize_t row):
        """The pattern of a row has changed: those behind it move."""
        self._stale = min(self._stale, row)

    cdef _update(self):
        """Bring the pattern up to date, unless further edits follow."""
        if self._editing:
            return
        if self._most > self._capacity:
            self._capacity = max(self._most, 2 * self._capacity)
            self._indices = <int32_t*>grown(self._indices, self._capacity, sizeof(int32_t))
        self.indptr, self.indices = self._indptr, self._indices
        if self._stale < self.m:
            with nogil:
                self._pattern()
            self.pattern_version += 1
        self._stale = self.m

    cdef void _pattern(self) noexcept nogil:
        """Pattern of the rows from the first stale one on, in the order of the rows."""
        cdef Py_ssize_t row, first, end = self._indptr[self._stale], k, e, i, q, c
        cdef LaneArrays* table
        cdef LaneArrays* source
        cdef ExpressionArrays* expression
        cdef int32_t unknown
        cdef bint shown
        for row in range(self._stale, self.m):
            self._stamp += 1
            first = row
            while self._table_of[first] == FURTHER:
                first -= 1
            shown = self._shown[row]
            if self._table_of[first] != FREE:
                table = self._arrays[self._table_of[first]]
                i = self._index_of[first]
                for e in range(table.begin[row - first], table.begin[row - first + 1]):
                    unknown = table.ref[i * table.ref_count + table.ref_of[e]]
                    table.at[i * table.entries + e] = -1
                    if shown and unknown >= 0:
                        table.at[i * table.entries + e] = self._place(
                            unknown + table.tangent[e], &end)
                k = self._term_of[row]
                while k >= 0:
                    unknown = self._terms[k].unknown
                    self._terms[k].at = -1
                    if shown and unknown >= 0:
                        self._terms[k].at = self._place(unknown, &end)
                    k = self._terms[k].next
                if self._expression_of[row] >= 0:
                    expression = self._expressions[self._expression_of[row]]
                    c = 0
                    for k in range(expression.quantities):
                        q = expression.quantity[k]
                        source = self._arrays[self._table_of[q]]
                        i = self._index_of[q]
                        for e in range(source.entries):
                            unknown = source.ref[i * source.ref_count + source.ref_of[e]]
                            expression.at[c] = -1
                            if shown and unknown >= 0:
                                expression.at[c] = self._place(unknown + source.tangent[e], &end)
                            c += 1
                    for k in range(expression.unknowns):
                        unknown = expression.unknown[k]
                        expression.at[c] = -1
                        if shown and unknown >= 0:
                            expression.at[c] = self._place(unknown, &end)
                        c += 1
            self._indptr[row + 1] = <int32_t>end

    cdef int32_t _place(self, int32_t unknown, Py_ssize_t* end) noexcept nogil:
        """Position of an unknown in the row that is being made."""
        if self._mark[unknown] != self._stamp:
            self._mark[unknown] = self._stamp
            self._slot[unknown] = <int32_t>end[0]
            self._indices[end[0]] = unknown
            end[0] += 1
        return self._slot[unknown]

    # ---- evaluation ----------------------------------------------------------------------------

    cdef int residuals(self, const double* x, double* r) noexcept nogil:
        return self._evaluate(x, r, NULL)

    cdef int linearise(self, const double* x, double* r, double* entries) noexcept nogil:
        return self._evaluate(x, r, entries)

    cdef int _evaluate(self, const double* x, double* r, double* entries) noexcept nogil:
        """Residuals, and entries unless NULL."""
        cdef Py_ssize_t t, i, k, first, count
        cdef LaneArrays* table
        cdef const double* value
        cdef const int32_t* at
        if self._editing or self._stale < self.m:
            with gil:
                self.raised = RuntimeError("rows cannot be evaluated while they are being edited")
            return -1
        self.unknowns.fill(x)
        memset(r, 0, self.m * sizeof(double))
        if entries != NULL:
            memset(entries, 0, self._indptr[self.m] * sizeof(double))
        for t in range(self._table_count):
            table = self._arrays[t]
            (<LaneTable>self._tables[t]).evaluate(self.unknowns)
            self.evaluated += table.active
            count = table.residuals
            if count == 1:
                for i in range(table.active):
                    if self._shown[table.first[i]]:
                        r[table.first[i]] = table.residual[i]
            else:
                for i in range(table.active):
                    first = table.first[i]
                    if self._shown[first]:
                        for k in range(count):
                            r[first + k] = table.residual[i * count + k]
            if entries != NULL:
                at, value = table.at, table.entry
                for k in range(table.active * table.entries):
                    if at[k] >= 0:
                        entries[at[k]] += value[k]
        value = self.unknowns.of_width(1)
        for k in range(self._term_count):
            if self._shown[self._terms[k].row]:
                r[self._terms[k].row] += self._terms[k].coefficient * value[self._terms[k].unknown]
                if entries != NULL and self._terms[k].at >= 0:
                    entries[self._terms[k].at] += self._terms[k].coefficient
        if self._expression_count:
            self._express(r, entries)
        return self._not_finite(r, entries)

    cdef void _express(self, double* r, double* entries) noexcept nogil:
        """Subtract the expressions."""
        cdef Py_ssize_t number, row
        for number in range(self._expression_count):
            if self._expressions[number] == NULL:
                continue
            row = self._expressions[number].row
            if self._shown[row]:
                self._subtract(number, r + row, entries, 0)

    cdef void _subtract(
        self, Py_ssize_t number, double* r, double* entries, Py_ssize_t shift
    ) noexcept nogil:
        """Subtract an expression from its row's residual; from entries, with shifted positions."""
        cdef Py_ssize_t k, e, q, i, c = 0
        cdef ExpressionArrays* one = self._expressions[number]
        cdef LaneArrays* source
        cdef const double* value = self.unknowns.of_width(1)
        for k in range(one.quantities):
            q = one.quantity[k]
            source = self._arrays[self._table_of[q]]
            one.inputs[k] = source.residual[self._index_of[q]]
        for k in range(one.unknowns):
            one.inputs[one.quantities + k] = value[one.unknown[k]]
        (<RowExpression>self._expression_at[number]).run()
        r[0] -= one.outputs[0]
        if entries == NULL:
            return
        for k in range(one.quantities):
            q = one.quantity[k]
            source = self._arrays[self._table_of[q]]
            i = self._index_of[q] * source.entries
            for e in range(source.entries):
                if one.at[c] >= 0:
                    entries[one.at[c] + shift] -= one.outputs[1 + k] * source.entry[i + e]
                c += 1
        for k in range(one.unknowns):
            if one.at[c] >= 0:
                entries[one.at[c] + shift] -= one.outputs[1 + one.quantities + k]
            c += 1

    cdef int _not_finite(self, const double* r, const double* entries) noexcept nogil:
        """1 + the first row with a number that is not finite, 0 if there is none."""
        cdef Py_ssize_t i, k, count = 0 if entries == NULL else self._indptr[self.m]
        # Zero times a number is 0 unless it is not finite: one test instead of one a number.
        if vanishes(r, self.m) and (entries == NULL or vanishes(entries, count)):
            return 0
        for i in range(self.m):
            if not isfinite(r[i]):
                return <int>i + 1
            if entries != NULL:
                for k in range(self._indptr[i], self._indptr[i + 1]):
                    if not isfinite(entries[k]):
                        return <int>i + 1
        return 0


cdef bint vanishes(const double* values, Py_ssize_t count) noexcept nogil:
    """Whether zero times all values is zero."""
    cdef double sum[8]
    cdef Py_ssize_t i = 0, k
    for k in range(8):
        sum[k] = 0
    while i + 8 <= count:
        for k in range(8):
            sum[k] += 0 * values[i + k]
        i += 8
    while i < count:
        sum[0] += 0 * values[i]
        i += 1
    for k in range(1, 8):
        sum[0] += sum[k]
    return sum[0] == 0
