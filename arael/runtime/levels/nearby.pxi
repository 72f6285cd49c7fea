"""Proofs, from a few rows and unknowns around them, that rows are independent of all others.

Let U be some unknowns and T all rows that have one of them. A row that is a combination of others
is, in U, the same combination of rows of T alone. So what is left of a row in U after projection
onto the span of the other rows of T there is no more than what is left of it in the whole system: a
row with a remainder in U is independent, whatever the rest of the system is. Nothing follows from
none.

U is found around the rows: as many unknowns as allowed, without those that T determines more than
once (the overdetermined part of the decomposition of A. Dulmage and N. Mendelsohn, Canadian Journal
of Mathematics 10, 1958), since there nothing is left of any row.
"""

import numpy as np

from libc.math cimport sqrt
from libc.stdint cimport int32_t, int64_t
from libc.stdlib cimport free, malloc
from libc.string cimport memset

from arael.runtime.address cimport address, writable

# Unknowns and rows that are looked at, at most.
cdef enum:
    COLUMNS = 64
    ROWS = 192
# What must be left of a row of unit length.
cdef double CLEARLY = 1e-3
# Derivatives of lengths by lengths below which a row that is asked about may be rounding.
cdef double VANISHING = 1e-6
# Length below which a row adds no direction to a span. Directions of rounding only make it larger.
cdef double NO_LENGTH = 1e-14


cdef struct Patch:
    int columns, rows
    int64_t column[COLUMNS]         # unknowns
    int64_t row[ROWS]               # rows; those that are asked about come first
    double entry[ROWS][COLUMNS]
    double scaled[ROWS]             # lengths of the whole rows
    int row_of[COLUMNS]             # matching
    int column_of[ROWS]
    char out[COLUMNS]               # overdetermined


def surely_independent(
    Rows rows not None, x, asked, counts, *, more=(), scales=None, sizes=(8, 24, COLUMNS)
):
    """Whether rows are proven to be independent of each other and of all others.

    Parameters
    ----------
    rows : Rows
        The system.
    x : (n,) float64
        Where.
    asked : sequence of int
        Rows of the system.
    counts : (m,) bool
        Rows that count; others are no equations.
    more : sequence of (indices, entries)
        Rows that the system does not have, which are asked about as well.
    scales : (n,) float64, optional
        Typical sizes of the unknowns.
    sizes : sequence of int
        Numbers of unknowns that are looked at, one after the other.

    Returns
    -------
    bool
        False proves nothing.
    """
    r = np.empty(rows.m)
    entries = np.empty(rows.indptr[rows.m] if rows.m else 0)
    cdef const double* at = <const double*>address(x, np.float64, rows.n)
    cdef double* value = <double*>writable(entries, np.float64)
    code = rows.linearise(at, <double*>writable(r, np.float64), value) if rows.m else 0
    if code != 0:
        rows.check(code)
        return False
    used = np.ascontiguousarray(counts, dtype=np.uint8)
    cdef const char* counted = <const char*>address(used, np.uint8, rows.m)
    cdef const double* scale = NULL
    if scales is not None:
        scale = <const double*>address(scales, np.float64, rows.n)
    # Rows by unknown.
    starts = np.zeros(rows.n + 2, np.int32)
    cdef int32_t* start = <int32_t*>writable(starts, np.int32)
    cdef Py_ssize_t i, e
    for i in range(rows.m):
        if counted[i]:
            for e in range(rows.indptr[i], rows.indptr[i + 1]):
                start[rows.indices[e] + 2] += 1
    for i in range(rows.n):
        start[i + 2] += start[i + 1]
    lists = np.empty(start[rows.n + 1], np.int32)
    cdef int32_t* listed = <int32_t*>writable(lists, np.int32)
    for i in range(rows.m):
        if counted[i]:
            for e in range(rows.indptr[i], rows.indptr[i + 1]):
                listed[start[rows.indices[e] + 1]] = <int32_t>i
                start[rows.indices[e] + 1] += 1
    # All of a row that is asked about, by position in its patch.
    given = [
        (np.array([rows.indices[e] for e in range(rows.indptr[<Py_ssize_t>k],
                                                  rows.indptr[<Py_ssize_t>k + 1])], np.int64),
         None, int(k))
        for k in asked
    ]  # fmt: skip
    given += [
        (np.asarray(own, np.int64), np.asarray(weights, np.float64), -1) for own, weights in more
    ]
    if not given or len(given) > ROWS // 4 or any(not len(own) for own, _, _ in given):
        return False
    cdef Patch* patch = <Patch*>malloc(sizeof(Patch))      # cleared for each size
    if patch == NULL:
        raise MemoryError
    places = np.full(rows.n, -1, np.int32)
    seen = np.zeros(rows.m, np.int8)
    try:
        for size in sizes:
            if _proven(rows, value, scale, start, listed, given, size, patch, places, seen):
                return True
            if patch.columns < size:        # all that hangs together was looked at
                return False
        return False
    finally:
        free(patch)


cdef bint _proven(
    Rows rows, const double* value, const double* scale, const int32_t* start,
    const int32_t* listed, list given, int size, Patch* patch, places, seen,
) except *:
    """Whether a patch of `size` unknowns proves it; `places` and `seen` are left as they were."""
    cdef int32_t* place = <int32_t*>writable(places, np.int32)
    cdef char* was = <char*>writable(seen, np.int8)
    cdef Py_ssize_t k, e, t, u, wanted = len(given)
    cdef int c, j
    cdef bint fits = True
    cdef double v, total
    memset(patch, 0, sizeof(Patch))
    for k in range(wanted):
        own, _, number = given[k]
        patch.row[k] = number
        if number >= 0:
            was[<Py_ssize_t>number] = 1
        for u in own:
            if place[u] < 0 and patch.columns < size:
                place[u] = patch.columns
                patch.column[patch.columns] = u
                patch.columns += 1
    patch.rows = <int>wanted
    # Unknowns in the order of their distance; all rows that have one of them.
    c = 0
    while c < patch.columns and fits:
        u = patch.column[c]
        for t in range(start[u], start[u + 1]):
            k = listed[t]
            if was[k]:
                continue
            if patch.rows == ROWS:
                fits = False
                break
            was[k] = 1
            patch.row[patch.rows] = k
            patch.rows += 1
            for e in range(rows.indptr[k], rows.indptr[k + 1]):
                if place[rows.indices[e]] < 0 and patch.columns < size:
                    place[rows.indices[e]] = patch.columns
                    patch.column[patch.columns] = rows.indices[e]
                    patch.columns += 1
        c += 1
    for j in range(patch.rows):
        total = 0.0
        if patch.row[j] >= 0:
            k = patch.row[j]
            for e in range(rows.indptr[k], rows.indptr[k + 1]):
                u = rows.indices[e]
                v = value[e] * (scale[u] if scale != NULL else 1.0)
                total += v * v
                if place[u] >= 0:
                    patch.entry[j][place[u]] += v
        else:
            own, weights, _ = given[j]
            for u, weight in zip(own, weights, strict=True):
                v = weight * (scale[u] if scale != NULL else 1.0)
                total += v * v
                if place[u] >= 0:
                    patch.entry[j][place[u]] += v
        patch.scaled[j] = sqrt(total)
    for j in range(patch.rows):
        if patch.row[j] >= 0:
            was[patch.row[j]] = 0
    for c in range(patch.columns):
        place[patch.column[c]] = -1
    if not fits:
        return False
    for j in range(patch.rows):
        if j < wanted and not patch.scaled[j] > VANISHING:
            return False
        if not patch.scaled[j] > 0.0:
            continue
        for c in range(patch.columns):
            patch.entry[j][c] /= patch.scaled[j]
    _leave_out(patch)
    for j in range(<int>wanted):        # a projection leaves no more than there is
        if not _length(patch, j) > CLEARLY:
            return False
    # Rows that are asked about come last: they have to be independent of each other, too.
    for j in range(<int>wanted, patch.rows):
        total = _orthogonal(patch, <int>wanted, j)
        _scale(patch, j, 1.0 / total if total > NO_LENGTH else 0.0)
    for j in range(<int>wanted):
        total = _orthogonal(patch, <int>wanted, patch.rows + j)
        if not total > CLEARLY:
            return False
        _scale(patch, j, 1.0 / total)
    return True


cdef inline int _at(Patch* patch, int number) noexcept nogil:
    """The row of a number: those that are asked about are numbered again, behind all others."""
    return number if number < patch.rows else number - patch.rows


cdef double _orthogonal(Patch* patch, int first, int number) noexcept nogil:
    """Make a row orthogonal to those of smaller numbers; its length then."""
    cdef int k, c, _twice, j = _at(patch, number)
    cdef double* row = patch.entry[j]
    cdef double* other
    cdef double v
    for _twice in range(2):
        for k in range(first, number):
            other = patch.entry[_at(patch, k)]
            v = 0.0
            for c in range(patch.columns):
                v += row[c] * other[c]
            if v != 0.0:
                for c in range(patch.columns):
                    row[c] -= v * other[c]
    return _length(patch, j)


cdef double _length(Patch* patch, int j) noexcept nogil:
    cdef int c
    cdef double total = 0.0
    for c in range(patch.columns):
        total += patch.entry[j][c] * patch.entry[j][c]
    return sqrt(total)


cdef void _scale(Patch* patch, int j, double factor) noexcept nogil:
    cdef int c
    for c in range(patch.columns):
        patch.entry[j][c] *= factor


cdef void _leave_out(Patch* patch) noexcept nogil:
    """Take the unknowns that are determined more than once out of all rows."""
    cdef int j, k, c, head, tail
    cdef int queue[ROWS]
    cdef int from_row[COLUMNS]
    cdef char reached[COLUMNS]
    cdef bint found
    for c in range(patch.columns):
        patch.row_of[c] = -1
    for j in range(patch.rows):
        patch.column_of[j] = -1
    # A matching with as many rows as possible: a way from each row to an unknown without one. What
    # a search without success has reached is determined more than once, and leads nowhere later.
    for j in range(patch.rows):
        memset(reached, 0, sizeof(reached))
        queue[0], head, tail, found = j, 0, 1, False
        while head < tail and not found:
            k = queue[head]
            head += 1
            for c in range(patch.columns):
                if patch.out[c] or reached[c] or patch.entry[k][c] == 0.0:
                    continue
                reached[c], from_row[c] = 1, k
                if patch.row_of[c] < 0:
                    found = True
                    break
                queue[tail] = patch.row_of[c]
                tail += 1
        if not found:
            for c in range(patch.columns):
                patch.out[c] |= reached[c]
            continue
        while True:
            k = from_row[c]
            head = patch.column_of[k]
            patch.row_of[c], patch.column_of[k] = k, c
            if k == j:
                break
            c = head
    for j in range(patch.rows):
        for c in range(patch.columns):
            if patch.out[c]:
                patch.entry[j][c] = 0.0
