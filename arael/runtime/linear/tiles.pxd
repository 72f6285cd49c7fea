# Dense kernels for panels of a Cholesky factor, as pointers to the best build for this processor.
#
# Column-major. Rows of a panel are padded to a multiple of `PAD` scalars, and every panel is
# followed by `PAD` scalars of padding, because the kernels use whole vectors.


cdef enum:
    PAD_BYTES = 64
    DEPTH = 240         # columns of a block of a large matrix, TILE_DEPTH in tiles.h
    PIECE = 48          # rows at which work may be split, TILE_PIECE

ctypedef Py_ssize_t (*potrf64_t)(Py_ssize_t, Py_ssize_t, Py_ssize_t, double*, Py_ssize_t,
                                 double*) noexcept nogil
ctypedef Py_ssize_t (*potrf32_t)(Py_ssize_t, Py_ssize_t, Py_ssize_t, float*, Py_ssize_t,
                                 float*) noexcept nogil
ctypedef void (*trsm64_t)(Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, const double*, double*,
                          Py_ssize_t) noexcept nogil
ctypedef void (*trsm32_t)(Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, const float*, float*,
                          Py_ssize_t) noexcept nogil
ctypedef void (*syrk64_t)(Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t, const double*,
                          Py_ssize_t, double*, Py_ssize_t) noexcept nogil
ctypedef void (*lessen64_t)(
    Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, const double*,
    Py_ssize_t, double*, Py_ssize_t, int
) noexcept nogil
ctypedef void (*syrk32_t)(Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t, const float*,
                          Py_ssize_t, float*, Py_ssize_t) noexcept nogil
ctypedef void (*lessen32_t)(
    Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, const float*,
    Py_ssize_t, float*, Py_ssize_t, int
) noexcept nogil
ctypedef void (*multiply64_t)(Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, const double*,
                              double*) noexcept nogil
ctypedef void (*multiply32_t)(Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, const float*,
                              float*) noexcept nogil
ctypedef void (*sweep64_t)(Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, const double*,
                           double*) noexcept nogil
ctypedef void (*sweep32_t)(Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, const float*,
                           float*) noexcept nogil
ctypedef void (*columns64_t)(
    const int*, Py_ssize_t, Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, double*, Py_ssize_t,
    double*, Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t
) noexcept nogil
ctypedef void (*update64_t)(
    const int*, Py_ssize_t, Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, double*, Py_ssize_t,
    Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t
) noexcept nogil
ctypedef void (*ascend64_t)(
    const int*, Py_ssize_t, Py_ssize_t, Py_ssize_t, const double*, Py_ssize_t, const double*,
    Py_ssize_t, const double*, const double*, double*, double*
) noexcept nogil

ctypedef struct Tiles64:
    potrf64_t potrf
    trsm64_t trsm
    syrk64_t syrk
    multiply64_t multiply
    multiply64_t transposed
    sweep64_t forward
    sweep64_t backward
    columns64_t extend_columns
    update64_t extend_update
    lessen64_t lessen
    ascend64_t ascend
ctypedef void (*columns32_t)(
    const int*, Py_ssize_t, Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, float*, Py_ssize_t,
    float*, Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t
) noexcept nogil
ctypedef void (*update32_t)(
    const int*, Py_ssize_t, Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, float*, Py_ssize_t,
    Py_ssize_t, Py_ssize_t, Py_ssize_t, Py_ssize_t
) noexcept nogil
ctypedef void (*ascend32_t)(
    const int*, Py_ssize_t, Py_ssize_t, Py_ssize_t, const float*, Py_ssize_t, const float*,
    Py_ssize_t, const float*, const float*, float*, float*
) noexcept nogil

ctypedef struct Tiles32:
    potrf32_t potrf
    trsm32_t trsm
    syrk32_t syrk
    multiply32_t multiply
    multiply32_t transposed
    sweep32_t forward
    sweep32_t backward
    columns32_t extend_columns
    update32_t extend_update
    lessen32_t lessen
    ascend32_t ascend

cdef Tiles64 tiles64
cdef Tiles32 tiles32

# Columns above which BLAS and LAPACK are faster than the selected kernels.
cdef Py_ssize_t large


cdef inline Py_ssize_t tile_potrf(
    Py_ssize_t n, Py_ssize_t height, Py_ssize_t reach, real* l, Py_ssize_t ld, real* inverse
) noexcept nogil:
    """Cholesky factor in place, 1 / diagonal to `inverse`; 0 or 1 + the failing pivot.

    At most `height` rows from the diagonal on are non-zero in a column, `reach` rows below the
    diagonal may be addressed.
    """
    if real is double:
        return tiles64.potrf(n, height, reach, l, ld, inverse)
    else:
        return tiles32.potrf(n, height, reach, l, ld, inverse)


cdef inline void tile_trsm(
    Py_ssize_t r, Py_ssize_t k, const real* l, Py_ssize_t ld, const real* inverse, real* x,
    Py_ssize_t ldx
) noexcept nogil:
    """x = x l^-T, x of shape (r, k)."""
    if real is double:
        tiles64.trsm(r, k, l, ld, inverse, x, ldx)
    else:
        tiles32.trsm(r, k, l, ld, inverse, x, ldx)


cdef inline void tile_syrk(
    Py_ssize_t begin, Py_ssize_t r, Py_ssize_t n, Py_ssize_t k, const real* x, Py_ssize_t ldx,
    real* u, Py_ssize_t ldu
) noexcept nogil:
    """Rows `begin` to r, n columns, of the lower triangle of u = -x x', x of shape (r, k).

    Entries above the triangle are overwritten.
    """
    if real is double:
        tiles64.syrk(begin, r, n, k, x, ldx, u, ldu)
    else:
        tiles32.syrk(begin, r, n, k, x, ldx, u, ldu)


cdef inline void tile_lessen(
    Py_ssize_t begin, Py_ssize_t r, Py_ssize_t k, const real* x, Py_ssize_t ldx, real* u,
    Py_ssize_t ldu
) noexcept nogil:
    """Rows `begin` to r of the lower triangle of u = u - x x', x (r, k)."""
    if real is double:
        tiles64.lessen(begin, r, r, k, x, ldx, x, ldx, u, ldu, 1)
    else:
        tiles32.lessen(begin, r, r, k, x, ldx, x, ldx, u, ldu, 1)


cdef inline void tile_multiply(
    Py_ssize_t r, Py_ssize_t k, const real* x, Py_ssize_t ldx, const real* b, real* y
) noexcept nogil:
    """y = -x b, x of shape (r, k), y padded like the rows of x."""
    if real is double:
        tiles64.multiply(r, k, x, ldx, b, y)
    else:
        tiles32.multiply(r, k, x, ldx, b, y)


cdef inline void tile_transposed(
    Py_ssize_t r, Py_ssize_t k, const real* x, Py_ssize_t ldx, const real* y, real* b
) noexcept nogil:
    """b = b - x' y, x of shape (r, k)."""
    if real is double:
        tiles64.transposed(r, k, x, ldx, y, b)
    else:
        tiles32.transposed(r, k, x, ldx, y, b)


cdef inline void tile_forward(
    Py_ssize_t n, Py_ssize_t height, const real* l, Py_ssize_t ld, const real* inverse, real* b
) noexcept nogil:
    """b = l^-1 b with the factor of `potrf`."""
    if real is double:
        tiles64.forward(n, height, l, ld, inverse, b)
    else:
        tiles32.forward(n, height, l, ld, inverse, b)


cdef inline void tile_backward(
    Py_ssize_t n, Py_ssize_t height, const real* l, Py_ssize_t ld, const real* inverse, real* b
) noexcept nogil:
    """b = l^-T b with the factor of `potrf`."""
    if real is double:
        tiles64.backward(n, height, l, ld, inverse, b)
    else:
        tiles32.backward(n, height, l, ld, inverse, b)


cdef inline void tile_extend_columns(
    const int* runs, Py_ssize_t inside, Py_ssize_t count, Py_ssize_t k, const real* u,
    Py_ssize_t ldu, real* triangle, Py_ssize_t ldt, real* panel, Py_ssize_t ldp, Py_ssize_t begin,
    Py_ssize_t end, Py_ssize_t side, Py_ssize_t own
) noexcept nogil:
    """Add a child's update matrix to columns `begin` to `end` of its parent, which has k.

    The right-hand side is row `side` of the update and goes to row `own` of the panel.
    """
    if real is double:
        tiles64.extend_columns(
            runs, inside, count, k, u, ldu, triangle, ldt, panel, ldp, begin, end, side, own
        )
    else:
        tiles32.extend_columns(
            runs, inside, count, k, u, ldu, triangle, ldt, panel, ldp, begin, end, side, own
        )


cdef inline void tile_extend_update(
    const int* runs, Py_ssize_t inside, Py_ssize_t count, Py_ssize_t k, const real* u,
    Py_ssize_t ldu, real* update, Py_ssize_t ldp, Py_ssize_t begin, Py_ssize_t end,
    Py_ssize_t side, Py_ssize_t own
) noexcept nogil:
    """Add a child's update matrix to columns `begin` to `end` of its parent's update matrix."""
    if real is double:
        tiles64.extend_update(runs, inside, count, k, u, ldu, update, ldp, begin, end, side, own)
    else:
        tiles32.extend_update(runs, inside, count, k, u, ldu, update, ldp, begin, end, side, own)


cdef inline void tile_ascend(
    const int* strips, Py_ssize_t count, Py_ssize_t r, Py_ssize_t k, const real* triangle,
    Py_ssize_t ldt, const real* panel, Py_ssize_t ldp, const real* inverse, const real* x,
    real* own, real* work
) noexcept nogil:
    """own = l^-T (t - p' x) for a front of k columns, l its triangle, p its panel of r rows.

    Row r of the panel holds t = l^-1 b. Strips (first, count) give the rows in x. `work` has the
    size of both leading dimensions.
    """
    if real is double:
        tiles64.ascend(strips, count, r, k, triangle, ldt, panel, ldp, inverse, x, own, work)
    else:
        tiles32.ascend(strips, count, r, k, triangle, ldt, panel, ldp, inverse, x, own, work)
