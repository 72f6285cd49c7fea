"""Rows of a system from the kernels of a compiled model, edited in place."""

import contextlib
from collections.abc import Mapping

import numpy as np

from arael.runtime.address cimport address, writable
from arael.runtime.levels.growth cimport grown
from libc.stdint cimport int32_t, int64_t


cdef class KernelRows(TableRows):
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
    evaluated : int
        Instances that were evaluated so far: what the evaluations cost.

    Raises
    ------
    ValueError
        If a constraint reads anything else, or the kernels are those of another model.
    """

    def __init__(self, layout, kernels=None, Py_ssize_t n=0):
        TableRows.__init__(self, layout, kernels, n)
        self._free, self._readers = {}, {}
        self.resize(n)

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
        self._reserve_marks(n)
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
