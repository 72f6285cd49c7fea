/* Includes the header named by KERNELS once per scalar type and instruction set, with
 *   T     scalar,  VB  bytes of a vector (0: plain scalars),
 *   F(x)  the name of function x in this instance,
 *   SQRT, LARGEST  square root and largest finite number of T,
 *   REGISTERS  vector registers of the instruction set.
 * The instances are called x_f64_base, x_f64_avx2, x_f64_avx512 and x_f32_... accordingly.
 */

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#if defined(__GNUC__)
#define KERNEL_INLINE static inline __attribute__((always_inline))
#define KERNEL_UNROLL _Pragma("GCC unroll 16")
#define KERNEL_BYTES 16
#define KERNEL_AHEAD(p) __builtin_prefetch(p)
#else
#define KERNEL_INLINE static __forceinline
#define KERNEL_UNROLL
#define KERNEL_BYTES 0
#define KERNEL_AHEAD(p)
#endif

#if defined(__x86_64__) && defined(__GNUC__)
#define KERNEL_X86 1
#define KERNEL_REGISTERS 16
#else
#define KERNEL_X86 0
#define KERNEL_REGISTERS 32
#endif

#define T double
#define SQRT sqrt
#define LARGEST DBL_MAX
#define VB KERNEL_BYTES
#define REGISTERS KERNEL_REGISTERS
#define F(x) x##_f64_base
#include KERNELS
#undef T
#undef SQRT
#undef LARGEST
#undef F
#define T float
#define SQRT sqrtf
#define LARGEST FLT_MAX
#define F(x) x##_f32_base
#include KERNELS
#undef T
#undef SQRT
#undef LARGEST
#undef VB
#undef REGISTERS
#undef F

#if KERNEL_X86

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
#define T double
#define SQRT sqrt
#define LARGEST DBL_MAX
#define VB 32
#define REGISTERS 16
#define F(x) x##_f64_avx2
#include KERNELS
#undef T
#undef SQRT
#undef LARGEST
#undef F
#define T float
#define SQRT sqrtf
#define LARGEST FLT_MAX
#define F(x) x##_f32_avx2
#include KERNELS
#undef T
#undef SQRT
#undef LARGEST
#undef VB
#undef REGISTERS
#undef F
#if defined(__clang__)
#pragma clang attribute pop
#define KERNEL_V4 "avx512f,avx512vl,avx512dq,fma"
#pragma clang attribute push(__attribute__((target(KERNEL_V4))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,fma")
#endif
#define T double
#define SQRT sqrt
#define LARGEST DBL_MAX
#define VB 64
#define REGISTERS 32
#define F(x) x##_f64_avx512
#include KERNELS
#undef T
#undef SQRT
#undef LARGEST
#undef F
#define T float
#define SQRT sqrtf
#define LARGEST FLT_MAX
#define F(x) x##_f32_avx512
#include KERNELS
#undef T
#undef SQRT
#undef LARGEST
#undef VB
#undef REGISTERS
#undef F
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#endif

/* Number of supported sets of base, avx2, avx512. */
static int kernel_sets(void) {
#if KERNEL_X86
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
    if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512vl")
        || !__builtin_cpu_supports("avx512dq")) return 2;
    return 3;
#else
    return 1;
#endif
}
