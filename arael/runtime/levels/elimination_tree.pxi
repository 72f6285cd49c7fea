"""Pattern of the Cholesky factor of J J', found without forming the product.

Row k of the factor is reached from the entries of row k of J J' along the elimination tree, which
grows with k. J. Liu, "The role of elimination trees in sparse factorization", SIAM J. Matrix
Anal. Appl. 11 (1990); T. Davis, "Algorithm 849: a concise sparse Cholesky factorization package",
ACM TOMS 31 (2005).
"""

import numpy as np

from libc.stdint cimport int32_t

from arael.runtime.address cimport address, writable


def factor_pattern(start, unknown, column_start, column_position):
    """Pattern of L, by columns and by rows.

    Parameters
    ----------
    start, unknown : (K + 1,), (e,) int32
        Unknowns of each row of J.
    column_start, column_position : (n + 1,), (e,) int32
        Rows of each unknown, ascending.

    Returns
    -------
    factor_start, factor_row, pattern_start, pattern_column : int32
        Rows of each column of L below the diagonal, and columns of each row left of it, ascending.
    """
    cdef Py_ssize_t count = len(start) - 1
    cdef const int32_t* at = <const int32_t*>address(start, np.int32)
    cdef const int32_t* of = <const int32_t*>address(unknown, np.int32)
    cdef const int32_t* column = <const int32_t*>address(column_start, np.int32)
    cdef const int32_t* row = <const int32_t*>address(column_position, np.int32)
    parents, marks = np.full(count, -1, np.int32), np.full(count, -1, np.int32)
    cdef int32_t* parent = <int32_t*>writable(parents, np.int32)
    cdef int32_t* mark = <int32_t*>writable(marks, np.int32)
    per_row, per_column = np.zeros(count, np.int64), np.zeros(count, np.int64)
    cdef long long[::1] in_row = per_row, in_column = per_column
    cdef Py_ssize_t k, e, t, i
    with nogil:
        for k in range(count):
            mark[k] = <int32_t>k
            for e in range(at[k], at[k + 1]):
                for t in range(column[of[e]], column[of[e] + 1]):
                    i = row[t]
                    if i >= k:
                        break
                    while mark[i] != k:
                        if parent[i] < 0:
                            parent[i] = <int32_t>k
                        in_row[k] += 1
                        in_column[i] += 1
                        mark[i] = <int32_t>k
                        i = parent[i]
    if int(per_row.sum()) > 2**31 - 1:
        raise MemoryError("the factor of the rows has more than 2^31 entries")
    factor_start = np.concatenate([[0], np.cumsum(per_column)]).astype(np.int32)
    pattern_start = np.concatenate([[0], np.cumsum(per_row)]).astype(np.int32)
    factor_row = np.empty(factor_start[count], np.int32)
    pattern_column = np.empty(pattern_start[count], np.int32)
    filled, row_filled = factor_start[:count].copy(), pattern_start[:count].copy()
    cdef int32_t* put = <int32_t*>writable(filled, np.int32)
    cdef int32_t* into = <int32_t*>writable(factor_row, np.int32)
    marks[:] = -1
    with nogil:
        for k in range(count):
            mark[k] = <int32_t>k
            for e in range(at[k], at[k + 1]):
                for t in range(column[of[e]], column[of[e] + 1]):
                    i = row[t]
                    if i >= k:
                        break
                    while mark[i] != k:
                        into[put[i]] = <int32_t>k
                        put[i] += 1
                        mark[i] = <int32_t>k
                        i = parent[i]
    # By columns in ascending order: the rows of L come out sorted.
    cdef int32_t* place = <int32_t*>writable(row_filled, np.int32)
    cdef int32_t* columns = <int32_t*>writable(pattern_column, np.int32)
    cdef const int32_t* first = <const int32_t*>address(factor_start, np.int32)
    with nogil:
        for i in range(count):
            for t in range(first[i], first[i + 1]):
                columns[place[into[t]]] = <int32_t>i
                place[into[t]] += 1
    return factor_start, factor_row, pattern_start, pattern_column
