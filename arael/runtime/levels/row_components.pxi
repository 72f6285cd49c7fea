"""What hangs together by rows."""

import numpy as np

from libc.stdint cimport int32_t

from arael.runtime.address cimport writable
from arael.runtime.assembly.compiled cimport join, numbered


def components(Rows rows not None):
    """Numbers of the components of a system, in order of their first rows.

    A row without unknowns, and an unknown without rows, is a component by itself.

    Returns
    -------
    (m + n,) int32
        By row, then by unknown.
    """
    cdef Py_ssize_t m = rows.m, i, e
    found = np.arange(m + rows.n, dtype=np.int32)
    cdef int32_t* parent = <int32_t*>writable(found, np.int32)
    with nogil:
        for i in range(m):
            for e in range(rows.indptr[i], rows.indptr[i + 1]):
                join(parent, <int32_t>i, <int32_t>(m + rows.indices[e]))
        numbered(parent, m + rows.n)
    return found
