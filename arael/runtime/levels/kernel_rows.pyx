# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Rows of a system from the kernels of a compiled model, edited in place."""

import contextlib
from collections.abc import Mapping

import numpy as np

from arael.runtime.address cimport address, writable
from arael.runtime.levels.lane_table cimport LaneArrays, LaneTable
from arael.runtime.levels.row_expression cimport ExpressionArrays, RowExpression
from arael.runtime.levels.rows cimport Rows
from arael.runtime.levels.unknown_windows cimport UnknownWindows
from libc.math cimport isfinite
from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport free, realloc
from libc.string cimport memset

# Instead of the number of a table.
cdef enum:
    FREE = -1                   # nothing is at the row
    FURTHER = -2                # a further row of the instance before it


cdef class KernelRows(Rows):
    """Equations that are instances of a model's constraints, evaluated by its kernels.

    An instance is known by its first row. Rows of removed instances stay, empty, until an instance
    of as many rows takes their place: numbers of other rows do not change. A row that is off has
    no entries and residual 0.

    Parameters
    ----------
    layout : Layout
        Of the compiled model. Each struct has at most one constraint, which reads its own data and,
        through refs, entities with plain parameters.
    kernels : capsule "arael.kernels" or None
        None: the expression machine evaluates all rows.
    n : int
        Unknowns.

    Attributes
    ----------
    n, m, pattern_version
        As of `Rows`.
    unknowns : UnknownWindows
        Also holds the constants at negative offsets.
    tables : dict of LaneTable by name of the struct
        Their `refs`, `widths`, `fields`, `defaults` and `residuals` describe the structs.

    Raises
    ------
    ValueError
        If a constraint reads anything else, or the kernels are those of another model.
    """

    def __init__(self, layout, kernels=None, Py_ssize_t n=0):
        cdef Py_ssize_t k
        self._free, self._readers, self._expression = {}, {}, []
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
        self.resize(n)

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

    # ---- edits ---------------------------------------------------------------------------------

    @contextlib.contextmanager
    def edit(self):
        """Let several edits in a ``with`` block change the pattern once, at its end."""
        self._editing += 1
        try:
            yield self
        finally:
            self._editing -= 1
            self._update()

    def resize(self, Py_ssize_t n):
        """Change the number of unknowns; no row may use one beyond it."""
        cdef Py_ssize_t k, i, count
        cdef LaneTable table
        if n < self.n:
            for table in self._table:
                count = len(table.refs)
                for i in range(table.arrays.count):
                    for k in range(count):
                        if table.arrays.ref[i * count + k] + <Py_ssize_t>table.widths[k] > n:
                            raise ValueError(
                                f"row {table.arrays.first[i]} uses an unknown beyond {n}")
        if n > self._mark_capacity:
            count = max(n, 2 * self._mark_capacity)
            self._mark = <int64_t*>grown(self._mark, count, sizeof(int64_t))
            self._slot = <int32_t*>grown(self._slot, count, sizeof(int32_t))
            memset(self._mark + self._mark_capacity, 0,
                   (count - self._mark_capacity) * sizeof(int64_t))
            self._mark_capacity = count
        self.unknowns.resize(n)
        self.n = n
        self._touch(self.m)
        self.pattern_version += 1
        self._update()

    def constant(self, values):
        """Offset (negative) of a block of constants: a fixed point, a fixed radius."""
        return self.unknowns.take(values)

    def set_constant(self, offset, values):
        """Change a block of constants."""
        self.unknowns.set(offset, values)

    def release_constant(self, offset):
        """Free a block of constants, which no row uses any more."""
        self.unknowns.release(offset)

    def add(self, struct, uses, data=(), *, on=True, quantity=False):
        """Add an instance.

        Parameters
        ----------
        struct : str
            Name of the struct.
        uses : sequence of int
            Per ref, in the order of the struct, the offset of the target's first scalar in the
            unknowns; a negative one is that of a block of constants. Two may be the same.
        data : sequence of float, or dict
            The fields in the order of the struct, as far as they are not to have their defaults; or
            some of them by name.
        on : bool
            Whether it takes part.
        quantity : bool
            It is no equation but an input of expressions: its row stays empty.

        Returns
        -------
        int
            Its first row.

        Raises
        ------
        ValueError
            There is no such struct, ref or field, or a target is beyond the unknowns.
        """
        if isinstance(data, Mapping):
            data = {name: [value] for name, value in data.items()}
        else:
            data = [data]
        return int(self.extend(struct, [uses], data, on=on, quantity=quantity)[0])

    def extend(self, struct, uses, data=None, *, on=True, quantity=False):
        """Add several instances of a struct; see `add`.

        Parameters
        ----------
        struct : str
        uses : (N, refs) int
        data : (N, up to fields) float, or dict of (N,) or scalar by name

        Returns
        -------
        (N,) int64
            First row of each.
        """
        cdef LaneTable table = self._named(struct)
        cdef Py_ssize_t refs = len(table.refs), fields = len(table.fields), i, k, row, count
        cdef const int32_t* offset
        cdef const double* value
        cdef int64_t* to
        uses = np.ascontiguousarray(uses, dtype=np.int32)
        if uses.ndim != 2 or uses.shape[1] != refs:
            raise ValueError(
                f"expected offsets of shape (N, {refs}) for the refs {', '.join(table.refs)} of "
                f"{struct}, found {uses.shape}")
        count = len(uses)
        offset = <const int32_t*>address(uses, np.int32)
        self._check(table, offset, count)
        values = filled(table, data, count)
        value = <const double*>address(values, np.float64)
        found = np.empty(count, dtype=np.int64)
        to = <int64_t*>writable(found, np.int64)
        table.reserve(table.arrays.count + count)
        self._most += count * table.arrays.entries
        number = self._table.index(table)
        for i in range(count):
            row = self._claim(table.arrays.residuals)
            self._table_of[row] = number
            self._index_of[row] = table.append(row, offset + i * refs, value + i * fields)
            for k in range(table.arrays.residuals):
                self._quantity[row + k] = bool(quantity)
            to[i] = row
            if on:
                self._activate(row, True)
            self._touch(row)
        self._update()
        return found

    def remove(self, row):
        """Remove the instance that begins at a row, with its expressions and terms.

        Raises
        ------
        ValueError
            No instance begins there, or an expression reads it.
        """
        cdef LaneTable table = self._table_at(row)
        cdef Py_ssize_t first = row, k, last, i
        if self._readers.get(first):
            raise ValueError(f"the quantity of row {first} is read by an expression")
        with self.edit():
            for k in range(first, first + table.arrays.residuals):
                self.remove_expression(k, missing_ok=True)
                self.remove_terms(k)
            self._activate(first, False)
            i, last = self._index_of[first], table.arrays.count - 1
            table.swap(i, last)
            self._index_of[table.arrays.first[i]] = <int32_t>i
            table.drop_last()
            self._most -= table.arrays.entries
            for k in range(first, first + table.arrays.residuals):
                self._table_of[k] = FREE
                self._quantity[k] = False
            self._free.setdefault(table.arrays.residuals, []).append(first)
            self._touch(first)

    def set_on(self, row, on):
        """Switch an instance on or off."""
        self._table_at(row)
        if self._quantity[<Py_ssize_t>row]:
            raise ValueError(f"row {row} is a quantity, which is always on")
        if bool(self._shown[<Py_ssize_t>row]) != bool(on):
            self._activate(row, bool(on))
            self._touch(row)
            self._update()

    def is_on(self, row):
        """Whether the instance takes part."""
        self._table_at(row)
        return bool(self._shown[<Py_ssize_t>row])

    def set_uses(self, row, uses):
        """Let an instance refer to other targets; see `add`."""
        cdef LaneTable table = self._table_at(row)
        cdef Py_ssize_t i = self._index_of[<Py_ssize_t>row], k, count = len(table.refs)
        offsets = np.ascontiguousarray(uses, dtype=np.int32)
        cdef const int32_t* offset = <const int32_t*>address(offsets, np.int32)
        if offsets.shape != (count,):
            raise ValueError(f"expected {count} offsets, found shape {offsets.shape}")
        self._check(table, offset, 1)
        for k in range(count):
            table.arrays.ref[i * count + k] = offset[k]
        table.place(i)
        if self._quantity[<Py_ssize_t>row]:
            for expression in self._expression:
                if expression is not None and row in expression.quantities:
                    self._touch(expression.row)
        self._touch(row)
        self._update()

    def set_data(self, row, field, value):
        """Set a field of an instance, or of several: `row` and `value` are arrays then."""
        cdef Py_ssize_t number
        if isinstance(row, (int, np.integer)):
            number = self._field(self._table_at(row), field)
            self.set_field(row, number, value)
            return
        rows = np.asarray(row).ravel()
        for one, new in zip(rows, np.broadcast_to(value, rows.shape), strict=True):
            self.set_data(int(one), field, new)

    def data(self, row, field=None):
        """A field of an instance; all of them, (fields,), without a name."""
        cdef LaneTable table = self._table_at(row)
        cdef Py_ssize_t k, count = len(table.fields)
        cdef const double* values = table.arrays.field + count * self._index_of[<Py_ssize_t>row]
        if field is not None:
            return values[<Py_ssize_t>self._field(table, field)]
        return np.array([values[k] for k in range(count)])

    def uses(self, row):
        """Offsets of the targets of an instance, (refs,)."""
        cdef LaneTable table = self._table_at(row)
        cdef Py_ssize_t k, count = len(table.refs)
        cdef const int32_t* offset = table.arrays.ref + count * self._index_of[<Py_ssize_t>row]
        return np.array([offset[k] for k in range(count)], dtype=np.int64)

    def struct(self, row):
        """Name of the struct of the instance that begins at a row."""
        return self._table_at(row).struct

    def instances(self):
        """First rows of all instances, in order, (N,)."""
        cdef Py_ssize_t row
        return np.array(
            [row for row in range(self.m) if self._table_of[row] >= 0], dtype=np.int64)

    def add_term(self, Py_ssize_t row, Py_ssize_t unknown, double coefficient):
        """Add a multiple of an unknown to a row: the slack of an inequality."""
        cdef Term* term
        self._equation(row)
        if not self.unknowns.holds(unknown, 1):
            raise ValueError(f"expected an unknown from 0 to {self.n - 1}, found {unknown}")
        if self._term_count == self._term_capacity:
            self._term_capacity = max(16, 2 * self._term_capacity)
            self._terms = <Term*>grown(self._terms, self._term_capacity, sizeof(Term))
        term = &self._terms[self._term_count]
        term.row, term.unknown, term.coefficient = <int32_t>row, <int32_t>unknown, coefficient
        term.next, term.at = self._term_of[row], -1
        self._term_of[row] = <int32_t>self._term_count
        self._term_count += 1
        self._most += 1
        self._touch(row)
        self._update()

    def remove_terms(self, Py_ssize_t row):
        """Remove all terms of a row."""
        cdef Py_ssize_t k, kept = 0
        if self._term_of[row] < 0:
            return
        for k in range(self._term_count):
            self._term_of[self._terms[k].row] = -1
            if self._terms[k].row != row:
                self._terms[kept] = self._terms[k]
                kept += 1
        self._most -= self._term_count - kept
        self._term_count = kept
        for k in range(kept):
            self._terms[k].next = self._term_of[self._terms[k].row]
            self._term_of[self._terms[k].row] = <int32_t>k
        self._touch(0)
        self._update()

    def add_expression(self, Py_ssize_t row, program, quantities=(), unknowns=(), numbers=()):
        """Subtract an expression over geometry from a row.

        The residual becomes ``row - value``, and its derivatives follow by the chain rule over the
        rows of the quantities. It is run by the expression machine, in C.

        Parameters
        ----------
        row : int
            A row of an equation, as a rule of a dimension with `value` 0.
        program : Tape
            Inputs are the quantities, the unknowns and the numbers, in this order; outputs the
            value, then its derivatives by each quantity and each unknown.
        quantities : sequence of int
            Rows of instances with one row, added with ``quantity=True``.
        unknowns : sequence of int
            Offsets of unknowns, or of constants.
        numbers : sequence of float
            What `set_numbers` changes: parameters of the sketch.

        Raises
        ------
        ValueError
            The row has an expression, or something is not what it has to be.
        """
        cdef LaneTable table
        cdef Py_ssize_t contributions = len(unknowns)
        cdef RowExpression made
        self._equation(row)
        if self._expression_of[row] >= 0:
            raise ValueError(f"row {row} has an expression")
        for one in quantities:
            table = self._table_at(one)
            if table.arrays.residuals != 1 or not self._quantity[<Py_ssize_t>one]:
                raise ValueError(f"row {one} is not a quantity of one row")
            contributions += table.arrays.entries
        for one in unknowns:
            if not self.unknowns.holds(one, 1):
                raise ValueError(f"expected an unknown from 0 to {self.n - 1}, found {one}")
        made = RowExpression(row, program, quantities, unknowns, numbers, contributions)
        number = self._expression.index(None) if None in self._expression else -1
        if number < 0:
            number = len(self._expression)
            self._expression.append(None)
            self._expressions = <ExpressionArrays**>grown(
                self._expressions, len(self._expression), sizeof(void*))
            self._expression_at = <void**>grown(
                self._expression_at, len(self._expression), sizeof(void*))
        self._expression[number] = made
        self._expressions[<Py_ssize_t>number] = &made.arrays
        self._expression_at[<Py_ssize_t>number] = <void*>made
        self._expression_count = len(self._expression)
        self._expression_of[row] = number
        for one in quantities:
            self._readers[one] = self._readers.get(one, 0) + 1
        self._most += contributions
        self._touch(row)
        self._update()

    def remove_expression(self, Py_ssize_t row, *, missing_ok=False):
        """Remove the expression of a row."""
        cdef Py_ssize_t number = self._expression_of[row] if 0 <= row < self.m else -1
        if number < 0:
            if missing_ok:
                return
            raise ValueError(f"row {row} has no expression")
        made = self._expression[number]
        self._expression[number] = None
        self._expressions[number] = NULL
        self._expression_of[row] = -1
        for one in made.quantities:
            self._readers[one] -= 1
        self._most -= (<RowExpression>made).arrays.contributions
        self._touch(row)
        self._update()

    def set_numbers(self, Py_ssize_t row, numbers):
        """Change the numbers that the expression of a row reads."""
        cdef Py_ssize_t number = self._expression_of[row] if 0 <= row < self.m else -1
        if number < 0:
            raise ValueError(f"row {row} has no expression")
        self._expression[number].set_numbers(numbers)

    def quantity(self, Py_ssize_t row):
        """Value of a quantity, or residual of an instance (rows,), as evaluated last."""
        cdef LaneTable table = self._table_at(row)
        cdef Py_ssize_t k, count = table.arrays.residuals
        cdef const double* found = table.arrays.residual + count * self._index_of[row]
        return np.array([found[k] for k in range(count)])

    cdef void set_field(self, Py_ssize_t row, Py_ssize_t field, double value) noexcept nogil:
        cdef LaneArrays* table = self._arrays[self._table_of[row]]
        cdef Py_ssize_t i = self._index_of[row]
        table.field[i * table.field_count + field] = value
        (<LaneTable>self._tables[self._table_of[row]]).place(i)

    # ---- rows ----------------------------------------------------------------------------------

    def _named(self, struct):
        table = self.tables.get(struct)
        if table is None:
            raise ValueError(f"expected one of {', '.join(self.tables)}, found {struct!r}")
        return table

    def _field(self, table, field):
        if isinstance(field, str):
            if field not in table.fields:
                raise ValueError(
                    f"expected one of {', '.join(table.fields)} of {table.struct}, found {field!r}")
            return table.fields.index(field)
        if not 0 <= field < len(table.fields):
            raise ValueError(f"{table.struct} has {len(table.fields)} fields, found {field}")
        return field

    cdef LaneTable _table_at(self, Py_ssize_t row):
        if not 0 <= row < self.m or self._table_of[row] < 0:
            raise ValueError(f"no instance begins at row {row}")
        return <LaneTable>self._tables[self._table_of[row]]

    def _equation(self, Py_ssize_t row):
        """Raise unless the row is one of an equation."""
        if not 0 <= row < self.m or self._table_of[row] == FREE or self._quantity[row]:
            raise ValueError(f"row {row} is not a row of an equation")

    cdef _check(self, LaneTable table, const int32_t* offset, Py_ssize_t count):
        """Raise unless all targets are unknowns or constants."""
        cdef Py_ssize_t i, k, refs = len(table.refs)
        widths = table.widths
        for k in range(refs):
            for i in range(count):
                if not self.unknowns.holds(offset[i * refs + k], widths[k]):
                    raise ValueError(
                        f"`{table.refs[k]}` of {table.struct} refers to {offset[i * refs + k]}: "
                        f"expected an unknown from 0 to {self.n - widths[k]}, or a constant")

    cdef Py_ssize_t _claim(self, Py_ssize_t count):
        """First of so many rows that were free, or are new."""
        cdef Py_ssize_t row, k
        spare = self._free.get(count)
        if spare:
            row = spare.pop()
        else:
            row = self.m
            self._reserve_rows(row + count)
            self._stale = min(self._stale, row)
            for k in range(row, row + count):  # empty until the pattern is brought up to date
                self._indptr[k + 1] = self._indptr[row]
            self.m += count
        for k in range(row, row + count):
            self._table_of[k], self._index_of[k] = FURTHER, -1
            self._shown[k] = self._quantity[k] = False
            self._expression_of[k] = self._term_of[k] = -1
        return row

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
        cdef Py_ssize_t number, k, e, q, i, c
        cdef ExpressionArrays* one
        cdef LaneArrays* source
        cdef const double* value = self.unknowns.of_width(1)
        for number in range(self._expression_count):
            if self._expressions[number] == NULL:
                continue
            one = self._expressions[number]
            if not self._shown[one.row]:
                continue
            for k in range(one.quantities):
                q = one.quantity[k]
                source = self._arrays[self._table_of[q]]
                one.inputs[k] = source.residual[self._index_of[q]]
            for k in range(one.unknowns):
                one.inputs[one.quantities + k] = value[one.unknown[k]]
            (<RowExpression>self._expression_at[number]).run()
            r[one.row] -= one.outputs[0]
            if entries == NULL:
                continue
            c = 0
            for k in range(one.quantities):
                q = one.quantity[k]
                source = self._arrays[self._table_of[q]]
                i = self._index_of[q] * source.entries
                for e in range(source.entries):
                    if one.at[c] >= 0:
                        entries[one.at[c]] -= one.outputs[1 + k] * source.entry[i + e]
                    c += 1
            for k in range(one.unknowns):
                if one.at[c] >= 0:
                    entries[one.at[c]] -= one.outputs[1 + one.quantities + k]
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


cdef void* grown(void* memory, Py_ssize_t count, size_t size) except NULL:
    memory = realloc(memory, max(count, 1) * size)
    if memory == NULL:
        raise MemoryError
    return memory


cdef filled(table, data, Py_ssize_t count):
    """(count, fields) with defaults where `data` leaves them out."""
    values = np.tile(table.defaults, (count, 1))
    if isinstance(data, Mapping):
        for name, column in data.items():
            if name not in table.fields:
                raise ValueError(
                    f"expected one of {', '.join(table.fields)} of {table.struct}, found {name!r}")
            values[:, table.fields.index(name)] = column
    elif data is not None:
        given = np.asarray(data, dtype=np.float64)
        if given.ndim != 2 or len(given) != count or given.shape[1] > len(table.fields):
            raise ValueError(
                f"expected data of shape ({count}, up to {len(table.fields)}) for the fields "
                f"{', '.join(table.fields)} of {table.struct}, found {given.shape}")
        values[:, : given.shape[1]] = given
    missing = np.isnan(values).any(axis=0)
    if missing.any():
        names = ", ".join(name for name, one in zip(table.fields, missing, strict=True) if one)
        raise ValueError(f"expected values of {names} of {table.struct}, found none")
    return values
