# cython: language_level=3
# distutils: include_dirs = arael/runtime/linear
# distutils: depends = arael/runtime/linear/tiles.h arael/runtime/linear/sweeps.h
"""Selection of the dense kernels in tiles.h for the current processor.

The header is compiled for several instruction sets; the best one that the processor supports is
selected at import. `use` selects another one, for tests and comparisons.
"""

cdef extern from *:
    """
    #include <float.h>
    #include <math.h>
    #include <stddef.h>

    #define NC 6

    #if defined(__GNUC__)
    #define TILE_INLINE static inline __attribute__((always_inline))
    #define TILE_UNROLL _Pragma("GCC unroll 8")
    #define BASE_BYTES 16
    #else
    #define TILE_INLINE static __forceinline
    #define TILE_UNROLL
    #define BASE_BYTES 0
    #endif

    #if defined(__x86_64__) && defined(__GNUC__)
    #define TILE_X86 1
    #else
    #define TILE_X86 0
    #endif

    #define TILE_V4 "avx512f,avx512vl,avx512dq,fma"

    #if defined(__aarch64__)
    #define BASE_ROWS 3
    #else
    #define BASE_ROWS 2
    #endif

    /* f64 */
    #define T double
    #define INTEGER long long
    #define BYTES 8
    #define SQRT sqrt
    #define LARGEST DBL_MAX
    #define VB BASE_BYTES
    #define RV BASE_ROWS
    #define F(x) x##_f64_base
    #include "tiles.h"
    #undef VB
    #undef RV
    #undef F
    #if TILE_X86
    #if defined(__clang__)
    #pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
    #else
    #pragma GCC push_options
    #pragma GCC target("avx2,fma")
    #endif
    #define VB 32
    #define RV 2
    #define F(x) x##_f64_avx2
    #include "tiles.h"
    #undef VB
    #undef RV
    #undef F
    #if defined(__clang__)
    #pragma clang attribute pop
    #pragma clang attribute push(__attribute__((target(TILE_V4))), apply_to = function)
    #else
    #pragma GCC pop_options
    #pragma GCC push_options
    #pragma GCC target("avx512f,avx512vl,avx512dq,fma")
    #endif
    #define VB 64
    #define RV 3
    #define F(x) x##_f64_avx512
    #include "tiles.h"
    #undef VB
    #undef RV
    #undef F
    #if defined(__clang__)
    #pragma clang attribute pop
    #else
    #pragma GCC pop_options
    #endif
    #endif
    #undef T
    #undef INTEGER
    #undef BYTES
    #undef SQRT
    #undef LARGEST

    /* f32 */
    #define T float
    #define INTEGER int
    #define BYTES 4
    #define SQRT sqrtf
    #define LARGEST FLT_MAX
    #define VB BASE_BYTES
    #define RV BASE_ROWS
    #define F(x) x##_f32_base
    #include "tiles.h"
    #undef VB
    #undef RV
    #undef F
    #if TILE_X86
    #if defined(__clang__)
    #pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
    #else
    #pragma GCC push_options
    #pragma GCC target("avx2,fma")
    #endif
    #define VB 32
    #define RV 2
    #define F(x) x##_f32_avx2
    #include "tiles.h"
    #undef VB
    #undef RV
    #undef F
    #if defined(__clang__)
    #pragma clang attribute pop
    #pragma clang attribute push(__attribute__((target(TILE_V4))), apply_to = function)
    #else
    #pragma GCC pop_options
    #pragma GCC push_options
    #pragma GCC target("avx512f,avx512vl,avx512dq,fma")
    #endif
    #define VB 64
    #define RV 3
    #define F(x) x##_f32_avx512
    #include "tiles.h"
    #undef VB
    #undef RV
    #undef F
    #if defined(__clang__)
    #pragma clang attribute pop
    #else
    #pragma GCC pop_options
    #endif
    #endif
    #undef T
    #undef INTEGER
    #undef BYTES

    #define TILE_TABLE(p, set) {(void *)potrf_##p##_##set, (void *)trsm_##p##_##set, \\
        (void *)syrk_##p##_##set, (void *)multiply_##p##_##set, (void *)transposed_##p##_##set, \\
        (void *)forward_##p##_##set, (void *)backward_##p##_##set, \\
        (void *)extend_columns_##p##_##set, (void *)extend_update_##p##_##set, \\
        (void *)lessen_##p##_##set, (void *)ascend_##p##_##set}
    static void *tile_tables[2][3][11] = {
    #if TILE_X86
        {TILE_TABLE(f32, base), TILE_TABLE(f32, avx2), TILE_TABLE(f32, avx512)},
        {TILE_TABLE(f64, base), TILE_TABLE(f64, avx2), TILE_TABLE(f64, avx512)},
    #else
        {TILE_TABLE(f32, base)}, {TILE_TABLE(f64, base)},
    #endif
    };

    /* Number of supported sets of base, avx2, avx512. */
    static int tile_sets(void) {
    #if TILE_X86
        __builtin_cpu_init();
        if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
        if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512vl")
            || !__builtin_cpu_supports("avx512dq")) return 2;
        return 3;
    #else
        return 1;
    #endif
    }
    """
    void* tile_tables[2][3][11]
    int tile_sets() nogil
    Py_ssize_t PY_SSIZE_T_MAX

_NAMES = ("base", "avx2", "avx512")


# Without wide vectors the BLAS of the wheel, which has kernels for every processor, is faster.
cdef Py_ssize_t NARROW = 1536


cdef void _take(int which):
    global f32, f64, large
    large = PY_SSIZE_T_MAX if which else NARROW
    cdef void** t = tile_tables[0][which]
    f32.potrf, f32.trsm, f32.syrk = <potrf32_t>t[0], <trsm32_t>t[1], <syrk32_t>t[2]
    f32.multiply, f32.transposed = <multiply32_t>t[3], <multiply32_t>t[4]
    f32.forward, f32.backward = <sweep32_t>t[5], <sweep32_t>t[6]
    f32.extend_columns = <columns32_t>t[7]
    f32.extend_update = <update32_t>t[8]
    f32.lessen, f32.ascend = <lessen32_t>t[9], <ascend32_t>t[10]
    t = tile_tables[1][which]
    f64.potrf, f64.trsm, f64.syrk = <potrf64_t>t[0], <trsm64_t>t[1], <syrk64_t>t[2]
    f64.multiply, f64.transposed = <multiply64_t>t[3], <multiply64_t>t[4]
    f64.forward, f64.backward = <sweep64_t>t[5], <sweep64_t>t[6]
    f64.extend_columns = <columns64_t>t[7]
    f64.extend_update = <update64_t>t[8]
    f64.lessen, f64.ascend = <lessen64_t>t[9], <ascend64_t>t[10]


def available():
    """Names of the supported instruction sets, the best one last."""
    return _NAMES[: tile_sets()]


def use(name):
    """Select the kernels of instruction set `name` for the whole process."""
    if name not in available():
        raise ValueError(f"instruction set {name!r} is not among {available()}")
    _take(_NAMES.index(name))


use(available()[-1])
