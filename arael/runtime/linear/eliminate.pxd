# Kernels of the block elimination, as pointers to the best build for this processor (eliminate.h).

from arael.runtime.linear.blas cimport real

cdef extern from *:
    """
    #ifndef ARAEL_ELIMINATE_TABLES
    #define ARAEL_ELIMINATE_TABLES
    /* Number of prefetched pairs of places; a list is padded by as many. */
    #define PAIRS_AHEAD 8
    typedef struct {
        long long scalar;       /* first scalar in the whole system */
        long long source;       /* diagonal block in the values */
        long long factor;       /* L in its storage */
        long long couplings;    /* first of its couplings; they end at the first of the next */
        long long size;
    } Entity;
    typedef struct {
        long long source;       /* block in the values */
        long long place;        /* Z */
        int padded;             /* the kept entity in a padded vector */
        int width;              /* scalars of the kept entity */
        int turned;             /* whether the block is stored transposed in the values */
        int kept;               /* number of the kept entity */
    } Coupling;
    typedef struct {
        long long place;        /* block in the values, row-major */
        int row, column;        /* its entities in a padded vector */
        int height, width;
    } Block;
    #endif
    """
    ctypedef struct Entity:
        long long scalar, source, factor, couplings, size
    ctypedef struct Coupling:
        long long source, place
        int padded, width, turned, kept
    ctypedef struct Block:
        long long place
        int row, column, height, width
    enum:
        PAIRS_AHEAD

ctypedef Py_ssize_t (*eliminate64_t)(Py_ssize_t, const Entity*, const Coupling*, const double*,
                                     const double*, double*, double*) noexcept nogil
ctypedef Py_ssize_t (*eliminate32_t)(Py_ssize_t, const Entity*, const Coupling*, const float*,
                                     const float*, float*, float*) noexcept nogil
ctypedef void (*gram64_t)(int, int, int, Py_ssize_t, const int*, const double*,
                          double*) noexcept nogil
ctypedef void (*gram32_t)(int, int, int, Py_ssize_t, const int*, const float*,
                          float*) noexcept nogil
ctypedef void (*sweep64_t)(Py_ssize_t, const Entity*, const Coupling*, const double*,
                           const double*, const double*, double*, double*) noexcept nogil
ctypedef void (*sweep32_t)(Py_ssize_t, const Entity*, const Coupling*, const float*, const float*,
                           const float*, float*, float*) noexcept nogil
ctypedef void (*apply64_t)(Py_ssize_t, const Entity*, const Coupling*, const double*,
                           const double*, double*, double*) noexcept nogil
ctypedef void (*apply32_t)(Py_ssize_t, const Entity*, const Coupling*, const float*, const float*,
                           float*, float*) noexcept nogil
ctypedef void (*symmetric64_t)(Py_ssize_t, const Block*, const double*, const double*,
                               double*) noexcept nogil
ctypedef void (*symmetric32_t)(Py_ssize_t, const Block*, const float*, const float*,
                               float*) noexcept nogil

ctypedef struct Kernels64:
    eliminate64_t eliminate
    gram64_t gram
    sweep64_t descend
    sweep64_t ascend
    apply64_t apply
    symmetric64_t symmetric

ctypedef struct Kernels32:
    eliminate32_t eliminate
    gram32_t gram
    sweep32_t descend
    sweep32_t ascend
    apply32_t apply
    symmetric32_t symmetric

cdef Kernels64 f64
cdef Kernels32 f32


cdef inline Py_ssize_t eliminate(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* values,
    const real* diagonal, real* factors, real* z
) noexcept nogil:
    """Factor and Z of all entities; 0 or 1 + the scalar whose pivot failed."""
    if real is double:
        return f64.eliminate(count, entities, couplings, values, diagonal, factors, z)
    else:
        return f32.eliminate(count, entities, couplings, values, diagonal, factors, z)


cdef inline void gram(
    int d, int h, int w, Py_ssize_t count, const int* pairs, const real* z, real* block
) noexcept nogil:
    """block -= sum of Za' Zb over `count` pairs of places in z; block (h, w), row-major."""
    if real is double:
        f64.gram(d, h, w, count, pairs, z, block)
    else:
        f32.gram(d, h, w, count, pairs, z, block)


cdef inline void descend(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* factors,
    const real* z, const real* b, real* t, real* y
) noexcept nogil:
    """t = L^-1 b of the eliminated, and y -= Z' t; y is padded."""
    if real is double:
        f64.descend(count, entities, couplings, factors, z, b, t, y)
    else:
        f32.descend(count, entities, couplings, factors, z, b, t, y)


cdef inline void ascend(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* factors,
    const real* z, const real* x, real* t, real* b
) noexcept nogil:
    """b = L^-T (t - Z x) of the eliminated; x is padded with zeros, t is overwritten."""
    if real is double:
        f64.ascend(count, entities, couplings, factors, z, x, t, b)
    else:
        f32.ascend(count, entities, couplings, factors, z, x, t, b)


cdef inline void apply(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* z,
    const real* x, real* t, real* y
) noexcept nogil:
    """y -= Z' Z x; x and y padded, t holds one entity."""
    if real is double:
        f64.apply(count, entities, couplings, z, x, t, y)
    else:
        f32.apply(count, entities, couplings, z, x, t, y)


cdef inline void symmetric(
    Py_ssize_t count, const Block* blocks, const real* values, const real* x, real* y
) noexcept nogil:
    """y += B x by the blocks of a lower triangle with full diagonal blocks; x and y padded."""
    if real is double:
        f64.symmetric(count, blocks, values, x, y)
    else:
        f32.symmetric(count, blocks, values, x, y)
