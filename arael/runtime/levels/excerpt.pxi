"""Some rows of a system as a system of their own: what is evaluated does not grow with the rest."""

import numpy as np

from arael.runtime.address cimport address, writable
from libc.math cimport isfinite
from libc.stdint cimport int32_t
from libc.string cimport memset


cdef class Excerpt(Rows):
    """Instances of a `KernelRows`, with unknowns and rows that are numbered by themselves.

    It reads the data of the system it is taken from, and lasts until the pattern of that changes.

    Parameters
    ----------
    of : KernelRows
    instances : sequence of int
        First rows of the instances.
    quantities : sequence of int
        Rows of the quantities that their expressions read.
    columns : (n,) int64
        Unknowns of the system: at least all that these rows have.

    Attributes
    ----------
    row_of : (m,) int32
        Row of the system, by row.

    Raises
    ------
    ValueError
        A row has another unknown.
    """

    cdef KernelRows _system
    cdef Py_ssize_t _system_version
    cdef object _keep
    cdef readonly object row_of
    cdef const int64_t* _column         # [n]
    cdef const int32_t* _row            # [m]
    cdef const int32_t* _first          # [m] first row of its instance
    cdef const int32_t* _lead           # [2 leads] table and instance of what is evaluated together
    cdef Py_ssize_t _leads

    def __init__(self, KernelRows of not None, instances, quantities, columns):
        cdef Py_ssize_t first, row, e, i
        cdef LaneTable table
        self._system, self._system_version = of, of.pattern_version
        columns = np.ascontiguousarray(columns, dtype=np.int64)
        at = {column: k for k, column in enumerate(columns.tolist())}
        leads, rows, firsts, indptr, indices = {}, [], [], [0], []
        for number, given in enumerate((*instances, *quantities)):
            first = given
            table = of._table_at(first)
            i = of._index_of[first]
            if i < table.arrays.active:
                leads[of._table_of[first], i // table._width] = i
            if number >= len(instances):
                continue
            for row in range(first, first + table.arrays.residuals):
                rows.append(row)
                firsts.append(first)
                for e in range(of._indptr[row], of._indptr[row + 1]):
                    if of._indices[e] not in at:
                        raise ValueError(f"row {row} has the unknown {of._indices[e]}")
                    indices.append(at[of._indices[e]])
                indptr.append(len(indices))
        self.n, self.m, self._leads = len(columns), len(rows), len(leads)
        lead = [(number, i) for (number, _), i in leads.items()]
        arrays = [
            np.array(one, dtype=np.int32).ravel() for one in (rows, firsts, lead, indptr, indices)
        ]
        self.row_of = arrays[0]
        self._row = <const int32_t*>address(arrays[0], np.int32)
        self._first = <const int32_t*>address(arrays[1], np.int32)
        self._lead = <const int32_t*>address(arrays[2], np.int32)
        self.indptr = <const int32_t*>address(arrays[3], np.int32)
        self.indices = <const int32_t*>address(arrays[4], np.int32)
        self._column = <const int64_t*>address(columns, np.int64)
        self._keep = arrays, columns
        self.pattern_version = 1

    cdef int residuals(self, const double* x, double* r) noexcept nogil:
        return self._evaluate(x, r, NULL)

    cdef int linearise(self, const double* x, double* r, double* entries) noexcept nogil:
        return self._evaluate(x, r, entries)

    cdef int _evaluate(self, const double* x, double* r, double* entries) noexcept nogil:
        """Residuals, and entries unless NULL."""
        cdef LaneArrays* table
        cdef Term* term
        cdef Py_ssize_t i, k, e, row, first, index, shift, t
        cdef int code = 0
        if self._system._editing or self._system.pattern_version != self._system_version:
            with gil:
                self.raised = RuntimeError("an excerpt of rows that were edited since")
            return -1
        for k in range(self.n):
            self._system.unknowns.put(self._column[k], x[k])
        for k in range(self._leads):
            t = self._lead[2 * k]
            self._system.evaluated += (<LaneTable>self._system._tables[t])._width
            (<LaneTable>self._system._tables[t]).evaluate_around(
                self._system.unknowns, self._lead[2 * k + 1])
        if entries != NULL:
            memset(entries, 0, self.indptr[self.m] * sizeof(double))
        for i in range(self.m):
            r[i] = 0.0
            row, first = self._row[i], self._first[i]
            if not self._system._shown[row]:
                continue
            table = self._system._arrays[self._system._table_of[first]]
            index, k = self._system._index_of[first], row - first
            r[i] = table.residual[index * table.residuals + k]
            shift = self.indptr[i] - self._system._indptr[row]
            if entries != NULL:
                for e in range(table.begin[k], table.begin[k + 1]):
                    if table.at[index * table.entries + e] >= 0:
                        entries[table.at[index * table.entries + e] + shift] += (
                            table.entry[index * table.entries + e])
            k = self._system._term_of[row]
            while k >= 0:
                term = &self._system._terms[k]
                r[i] += term.coefficient * self._system.unknowns.of_width(1)[term.unknown]
                if entries != NULL and term.at >= 0:
                    entries[term.at + shift] += term.coefficient
                k = term.next
            if self._system._expression_of[row] >= 0:
                self._system._subtract(self._system._expression_of[row], r + i, entries, shift)
        for i in range(self.m):
            if not isfinite(r[i]) and code == 0:
                code = <int>i + 1
            if entries != NULL:
                for e in range(self.indptr[i], self.indptr[i + 1]):
                    if not isfinite(entries[e]) and (code == 0 or code > i + 1):
                        code = <int>i + 1
        return code
