"""A cost model of fronts.

Only ratios matter: the model decides which supernodes to merge and compares orderings and solvers.
Fitted to measured refactorisations, f64 on one core with wide vectors; the terms are a constant for
the calls, the dependent square roots along the diagonal, floating-point work, zeroing and reading
the columns, and moving the update matrix to the parent.
"""

import numpy as np


def time_of_front(columns, rows):
    """Predicted nanoseconds to assemble and factor a front.

    Parameters
    ----------
    columns, rows : number or array
        Scalar columns k and scalar rows r below them.
    """
    k, r = np.broadcast_arrays(
        np.asarray(columns, dtype=np.float64), np.asarray(rows, dtype=np.float64)
    )
    found = np.empty(k.shape)
    cdef double[::1] of_k = np.ascontiguousarray(k.ravel()), of_r = np.ascontiguousarray(r.ravel())
    cdef double[::1] time = found.reshape(-1)
    cdef Py_ssize_t i
    for i in range(len(of_k)):
        time[i] = front_time(of_k[i], of_r[i])
    return found
