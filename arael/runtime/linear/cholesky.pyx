# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Dense Cholesky on threads: the kernels of tiles.h over rows that threads share.

A triangle goes by blocks of columns, each in two steps: its own rows by one thread, then the rows
below by all of them. Rows are handed out in pieces of whole tiles, and every entry is summed in the
same order whoever has it, so results have the same bits on any number of threads.
"""

from arael.runtime.linear cimport tiles
from arael.runtime.linear.blas cimport real
from arael.runtime.pool cimport share

cdef extern from *:
    Py_ssize_t PY_SSIZE_T_MAX

DENSE = PY_SSIZE_T_MAX // 2

cdef enum:
    BLOCK = 96          # columns of a block: whole tiles in every build
    PIECE = 48          # rows of a piece are a multiple of this: whole tiles in every build
    OVERSHOOT = 16      # rows behind the last that a kernel may touch, at most

# Floating-point operations from which a piece of rows pays.
cdef Py_ssize_t GRAIN = 2_000_000

cdef struct Rows:
    int single
    Py_ssize_t r, begin, k, ld, ldx, piece, pieces
    const void* l
    const void* inverse
    void* x


cdef Py_ssize_t factor_triangle(
    int threads, Py_ssize_t k, real* l, Py_ssize_t ld, real* inverse
) noexcept nogil:
    cdef Py_ssize_t begin, end, status
    cdef real kept[OVERSHOOT * BLOCK]
    if k < BLOCKED:
        return tiles.potrf(0, k, k, DENSE, l, ld, inverse)
    begin = 0
    while begin < k:
        end = min(begin + BLOCK, k)
        # Kernels work by whole vectors, and rows below the block have their turn later.
        keep_rows(k, begin, end, l, ld, kept, True)
        status = tiles.potrf(begin, end, end, DENSE, l, ld, inverse)
        keep_rows(k, begin, end, l, ld, kept, False)
        if status:
            return status
        if end < k:
            divide(threads, k - end, begin, end, l, ld, inverse, l + end, ld)
        begin = end
    return 0


cdef void keep_rows(
    Py_ssize_t k, Py_ssize_t begin, Py_ssize_t end, real* l, Py_ssize_t ld, real* kept, bint away
) noexcept nogil:
    """Put the rows behind a block aside, or back."""
    cdef Py_ssize_t i, j, rows = min(k - end, OVERSHOOT)
    for j in range(begin, end):
        for i in range(rows):
            if away:
                kept[OVERSHOOT * (j - begin) + i] = l[end + i + j * ld]
            else:
                l[end + i + j * ld] = kept[OVERSHOOT * (j - begin) + i]


cdef void divide_rows(
    int threads, Py_ssize_t r, Py_ssize_t k, const real* l, Py_ssize_t ld, const real* inverse,
    real* x, Py_ssize_t ldx
) noexcept nogil:
    divide(threads, r, 0, k, l, ld, inverse, x, ldx)


cdef void divide(
    int threads, Py_ssize_t r, Py_ssize_t begin, Py_ssize_t k, const real* l, Py_ssize_t ld,
    const real* inverse, real* x, Py_ssize_t ldx
) noexcept nogil:
    """Columns `begin` to k of x = x l^-T, x of shape (r, k)."""
    cdef Rows job
    if threads <= 1:
        tiles.trsm(r, begin, k, l, ld, inverse, x, ldx)
        return
    job.single = sizeof(real) == sizeof(float)
    job.r, job.begin, job.k, job.ld, job.ldx = r, begin, k, ld, ldx
    job.l, job.inverse, job.x = l, inverse, x
    cut(&job, (k - begin) * (k + begin))
    share(threads, job.pieces, divide_piece, &job)


cdef void divide_piece(void* job, Py_ssize_t item) noexcept nogil:
    cdef Rows* rows = <Rows*>job
    cdef Py_ssize_t first = item * rows.piece, r = min(rows.piece, rows.r - first)
    if rows.single:
        tiles.trsm(r, rows.begin, rows.k, <const float*>rows.l, rows.ld,
                   <const float*>rows.inverse, <float*>rows.x + first, rows.ldx)
    else:
        tiles.trsm(r, rows.begin, rows.k, <const double*>rows.l, rows.ld,
                   <const double*>rows.inverse, <double*>rows.x + first, rows.ldx)


cdef void outer_product(
    int threads, Py_ssize_t r, Py_ssize_t k, const real* x, Py_ssize_t ldx, real* u, Py_ssize_t ldu
) noexcept nogil:
    cdef Rows job
    if threads <= 1:
        tiles.syrk(0, r, k, x, ldx, u, ldu)
        return
    job.single = sizeof(real) == sizeof(float)
    job.r, job.begin, job.k, job.ld, job.ldx = r, 0, k, ldu, ldx
    job.l, job.x = x, u
    cut(&job, r * k)
    share(threads, job.pieces, multiply_piece, &job)


cdef void multiply_piece(void* job, Py_ssize_t item) noexcept nogil:
    cdef Rows* rows = <Rows*>job
    # The longest rows first.
    cdef Py_ssize_t first = (rows.pieces - 1 - item) * rows.piece
    cdef Py_ssize_t end = min(first + rows.piece, rows.r)
    if rows.single:
        tiles.syrk(first, end, rows.k, <const float*>rows.l, rows.ldx, <float*>rows.x, rows.ld)
    else:
        tiles.syrk(first, end, rows.k, <const double*>rows.l, rows.ldx, <double*>rows.x, rows.ld)


cdef void cut(Rows* job, Py_ssize_t flops) noexcept nogil:
    """Pieces of rows of so many floating-point operations each that a piece pays."""
    job.piece = PIECE * max(1, (GRAIN // max(flops, 1) + PIECE - 1) // PIECE)
    job.pieces = (job.r + job.piece - 1) // job.piece
