/* What a file of kernels is compiled for: SET_AVX512, SET_AVX2 or the baseline; setup.py chooses it
 * together with the options of the compiler.
 *
 *   VB         bytes of a vector (0: plain scalars)
 *   RV         vectors of rows in a tile
 *   REGISTERS  vector registers
 *   SET_NAME   end of the names of tables
 *   INLINE, UNROLL, AHEAD  what compilers spell differently
 */

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#if defined(SET_AVX512)
#define SET_NAME avx512
#define VB 64
#define RV 3
#define REGISTERS 32
#elif defined(SET_AVX2)
#define SET_NAME avx2
#define VB 32
#define RV 2
#define REGISTERS 16
#else
#define SET_NAME base
#if defined(__GNUC__)
#define VB 16
#else
#define VB 0
#endif
#if defined(__aarch64__)
#define RV 3
#define REGISTERS 32
#else
#define RV 2
#define REGISTERS 16
#endif
#endif

/* Sizes that are unrolled are those of vectors, points, poses and cameras: 1, 2, 3, 6 and 9. The
 * baseline of x86-64, which few processors need, is left rolled up. */
#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#define AHEAD(p) __builtin_prefetch(p)
#if defined(__x86_64__) && !defined(SET_AVX2) && !defined(SET_AVX512)
#define UNROLL
#else
#define UNROLL _Pragma("GCC unroll 16")
#endif
#else
#define INLINE static __forceinline
#define UNROLL
#define AHEAD(p)
#endif

#define JOIN_NAMES(name, set) name##_##set
#define JOIN(name, set) JOIN_NAMES(name, set)
