/* The kernels of all instruction sets that are compiled, the best one last: the baseline, and on
 * x86-64 AVX2 and AVX-512, or that of the two which the machine has that arael was built on. */

typedef struct {
    const char *name;
    int (*runs_here)(void);
    void *const *tiles[2]; /* for floats and doubles */
    void *const *eliminate[2];
} KernelSet;

#define KERNELS_OF(set)                            \
    extern void *const arael_tiles_##set[2][11];   \
    extern void *const arael_eliminate_##set[2][6];
#define KERNEL_SET(set)                                                                    \
    {#set, runs_##set, {arael_tiles_##set[0], arael_tiles_##set[1]},                       \
     {arael_eliminate_##set[0], arael_eliminate_##set[1]}}

KERNELS_OF(base)
static int runs_base(void) { return 1; }

#if defined(KERNELS_AVX2)
KERNELS_OF(avx2)
static int runs_avx2(void) {
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
#endif

#if defined(KERNELS_AVX512)
KERNELS_OF(avx512)
static int runs_avx512(void) {
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")
           && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("fma");
}
#endif

static const KernelSet kernel_sets[] = {
    KERNEL_SET(base),
#if defined(KERNELS_AVX2)
    KERNEL_SET(avx2),
#endif
#if defined(KERNELS_AVX512)
    KERNEL_SET(avx512),
#endif
};

enum { KERNEL_SETS = sizeof(kernel_sets) / sizeof(kernel_sets[0]) };
