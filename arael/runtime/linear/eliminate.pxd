# Kernels of the block elimination, as pointers to the best build for this processor (eliminate.h).


cdef extern from "eliminate_tables.h":
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
ctypedef void (*descend64_t)(Py_ssize_t, const Entity*, const Coupling*, const double*,
                             const double*, const double*, double*, double*) noexcept nogil
ctypedef void (*descend32_t)(Py_ssize_t, const Entity*, const Coupling*, const float*, const float*,
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
    descend64_t descend
    descend64_t ascend
    apply64_t apply
    symmetric64_t symmetric

ctypedef struct Kernels32:
    eliminate32_t eliminate
    gram32_t gram
    descend32_t descend
    descend32_t ascend
    apply32_t apply
    symmetric32_t symmetric

cdef Kernels64 blocks64
cdef Kernels32 blocks32


cdef inline Py_ssize_t block_eliminate(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* values,
    const real* diagonal, real* factors, real* z
) noexcept nogil:
    """Factor and Z of all entities; 0 or 1 + the scalar whose pivot failed."""
    if real is double:
        return blocks64.eliminate(count, entities, couplings, values, diagonal, factors, z)
    else:
        return blocks32.eliminate(count, entities, couplings, values, diagonal, factors, z)


cdef inline void block_gram(
    int d, int h, int w, Py_ssize_t count, const int* pairs, const real* z, real* block
) noexcept nogil:
    """block -= sum of Za' Zb over `count` pairs of places in z; block (h, w), row-major."""
    if real is double:
        blocks64.gram(d, h, w, count, pairs, z, block)
    else:
        blocks32.gram(d, h, w, count, pairs, z, block)


cdef inline void block_descend(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* factors,
    const real* z, const real* b, real* t, real* y
) noexcept nogil:
    """t = L^-1 b of the eliminated, and y -= Z' t; y is padded."""
    if real is double:
        blocks64.descend(count, entities, couplings, factors, z, b, t, y)
    else:
        blocks32.descend(count, entities, couplings, factors, z, b, t, y)


cdef inline void block_ascend(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* factors,
    const real* z, const real* x, real* t, real* b
) noexcept nogil:
    """b = L^-T (t - Z x) of the eliminated; x is padded with zeros, t is overwritten."""
    if real is double:
        blocks64.ascend(count, entities, couplings, factors, z, x, t, b)
    else:
        blocks32.ascend(count, entities, couplings, factors, z, x, t, b)


cdef inline void block_apply(
    Py_ssize_t count, const Entity* entities, const Coupling* couplings, const real* z,
    const real* x, real* t, real* y
) noexcept nogil:
    """y -= Z' Z x; x and y padded, t holds one entity."""
    if real is double:
        blocks64.apply(count, entities, couplings, z, x, t, y)
    else:
        blocks32.apply(count, entities, couplings, z, x, t, y)


cdef inline void block_symmetric(
    Py_ssize_t count, const Block* blocks, const real* values, const real* x, real* y
) noexcept nogil:
    """y += B x by the blocks of a lower triangle with full diagonal blocks; x and y padded."""
    if real is double:
        blocks64.symmetric(count, blocks, values, x, y)
    else:
        blocks32.symmetric(count, blocks, values, x, y)
