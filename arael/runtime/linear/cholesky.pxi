"""Multithreaded dense Cholesky: the kernels of tiles.h on pieces of rows.

Rows are split at tile boundaries, so that every entry is summed in the same order, and results are
bit-identical for any number of threads.
"""

from arael.runtime.parallel.compiled cimport distribute

cdef extern from *:
    Py_ssize_t PY_SSIZE_T_MAX

# Every row of a dense triangle may be addressed from every column.
cdef Py_ssize_t DENSE = PY_SSIZE_T_MAX // 2

cdef enum:
    OVERSHOOT = 16      # maximum number of rows after the last one that a kernel may touch

# Minimum floating-point operations of a piece of rows.
cdef Py_ssize_t GRAIN = 2_000_000

# Work of the threads: rows of x to divide, or of u from which products of x are subtracted.
cdef struct Rows:
    bint single, minus
    Py_ssize_t r, n, k, ld, ldx, piece, pieces
    const void* l
    const void* inverse
    void* x


cdef bint is_shared(int threads, Py_ssize_t k) noexcept nogil:
    return threads > 1 and k > 2 * DEPTH


cdef Py_ssize_t factor_triangle(
    int threads, Py_ssize_t k, real* l, Py_ssize_t ld, real* inverse
) noexcept nogil:
    cdef Py_ssize_t begin = 0, status, columns, rest
    cdef real kept[OVERSHOOT * DEPTH]
    cdef real* corner
    # As in `potrf`, with the rows below each corner distributed among threads.
    while True:
        corner, columns = l + begin * (ld + 1), min(k - begin, <Py_ssize_t>DEPTH)
        rest = k - begin - columns
        keep_rows(columns, rest, corner + columns, ld, kept, True)
        status = tile_potrf(columns, columns, DENSE, corner, ld, inverse + begin)
        if status:
            return begin + status
        if rest == 0:
            return 0
        keep_rows(columns, rest, corner + columns, ld, kept, False)
        divide_rows(threads, rest, columns, corner, ld, inverse + begin, corner + columns, ld)
        take_products(threads, rest, rest, columns, corner + columns, ld,
                      corner + columns * (ld + 1), ld, True)
        begin += columns


cdef void keep_rows(
    Py_ssize_t columns, Py_ssize_t rest, real* below, Py_ssize_t ld, real* kept, bint away
) noexcept nogil:
    """Save or restore the rows after a corner, which its factorisation overwrites."""
    cdef Py_ssize_t i, j, rows = min(rest, <Py_ssize_t>OVERSHOOT)
    for j in range(columns):
        for i in range(rows):
            if away:
                kept[OVERSHOOT * j + i] = below[i + j * ld]
            else:
                below[i + j * ld] = kept[OVERSHOOT * j + i]


cdef void divide_rows(
    int threads, Py_ssize_t r, Py_ssize_t k, const real* l, Py_ssize_t ld, const real* inverse,
    real* x, Py_ssize_t ldx
) noexcept nogil:
    cdef Rows job
    if threads <= 1:
        tile_trsm(r, k, l, ld, inverse, x, ldx)
        return
    job.single = sizeof(real) == sizeof(float)
    job.r, job.k, job.ld, job.ldx = r, k, ld, ldx
    job.l, job.inverse, job.x = l, inverse, x
    cut(&job, k * k)
    distribute(threads, job.pieces, divide_piece, &job)


cdef void divide_piece(void* job, Py_ssize_t item) noexcept nogil:
    cdef Rows* rows = <Rows*>job
    cdef Py_ssize_t first = item * rows.piece, r = min(rows.piece, rows.r - first)
    if rows.single:
        tile_trsm(r, rows.k, <const float*>rows.l, rows.ld, <const float*>rows.inverse,
                  <float*>rows.x + first, rows.ldx)
    else:
        tile_trsm(r, rows.k, <const double*>rows.l, rows.ld, <const double*>rows.inverse,
                  <double*>rows.x + first, rows.ldx)


cdef void outer_product(
    int threads, Py_ssize_t r, Py_ssize_t n, Py_ssize_t k, const real* x, Py_ssize_t ldx, real* u,
    Py_ssize_t ldu
) noexcept nogil:
    take_products(threads, r, n, k, x, ldx, u, ldu, False)


cdef void take_products(
    int threads, Py_ssize_t r, Py_ssize_t n, Py_ssize_t k, const real* x, Py_ssize_t ldx, real* u,
    Py_ssize_t ldu, bint minus
) noexcept nogil:
    """Columns to n of the lower triangle of u = -x x', or of u = u - x x' if `minus`."""
    cdef Rows job
    job.single, job.minus = sizeof(real) == sizeof(float), minus
    job.r, job.n, job.k, job.ld, job.ldx = r, n, k, ldx, ldu
    job.l, job.x = x, u
    cut(&job, r * k)
    if threads <= 1:
        job.piece, job.pieces = r, 1
    distribute(threads, job.pieces, product_piece, &job)


cdef void product_piece(void* job, Py_ssize_t item) noexcept nogil:
    cdef Rows* rows = <Rows*>job
    # The longest rows first.
    cdef Py_ssize_t first = (rows.pieces - 1 - item) * rows.piece
    cdef Py_ssize_t end = min(first + rows.piece, rows.r)
    if rows.single:
        row_products(rows, first, end, <const float*>rows.l, <float*>rows.x)
    else:
        row_products(rows, first, end, <const double*>rows.l, <double*>rows.x)


cdef void row_products(
    const Rows* rows, Py_ssize_t first, Py_ssize_t end, const real* x, real* u
) noexcept nogil:
    if rows.minus:
        tile_lessen(first, end, rows.k, x, rows.ld, u, rows.ldx)
    else:
        tile_syrk(first, end, min(end, rows.n), rows.k, x, rows.ld, u, rows.ldx)


cdef void cut(Rows* job, Py_ssize_t flops) noexcept nogil:
    """Pieces of rows with enough floating-point operations each."""
    job.piece = PIECE * max(<Py_ssize_t>1, GRAIN // max(<Py_ssize_t>1, flops * PIECE))
    job.pieces = (job.r + job.piece - 1) // job.piece
