/* The kernels of all instruction sets that are compiled: KERNEL_SETS is 3 for x86, else 1. */

#define KERNELS_OF(set)                        \
    extern void *const arael_tiles_##set[2][11]; \
    extern void *const arael_eliminate_##set[2][6];
KERNELS_OF(base)
#if KERNEL_SETS == 3
KERNELS_OF(avx2)
KERNELS_OF(avx512)
#endif

/* Kernels for floats, then those for doubles; of base, AVX2 and AVX-512. */
static void *const *const tile_tables[KERNEL_SETS][2] = {
    {arael_tiles_base[0], arael_tiles_base[1]},
#if KERNEL_SETS == 3
    {arael_tiles_avx2[0], arael_tiles_avx2[1]},
    {arael_tiles_avx512[0], arael_tiles_avx512[1]},
#endif
};
static void *const *const eliminate_tables[KERNEL_SETS][2] = {
    {arael_eliminate_base[0], arael_eliminate_base[1]},
#if KERNEL_SETS == 3
    {arael_eliminate_avx2[0], arael_eliminate_avx2[1]},
    {arael_eliminate_avx512[0], arael_eliminate_avx512[1]},
#endif
};

/* Number of them that this processor runs. */
static int kernel_sets(void) {
#if KERNEL_SETS == 3
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
    if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512vl")
        || !__builtin_cpu_supports("avx512dq")) return 2;
    return 3;
#else
    return 1;
#endif
}
