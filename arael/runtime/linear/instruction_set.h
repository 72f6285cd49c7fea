/* What a file of kernels is compiled for: the instruction set SET, which setup.py chooses together
 * with the compiler's options, 0 baseline, 1 AVX2, 2 AVX-512.
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

#if SET == 2
#define SET_NAME avx512
#define VB 64
#define RV 3
#define REGISTERS 32
#elif SET == 1
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

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#define UNROLL _Pragma("GCC unroll 16")
#define AHEAD(p) __builtin_prefetch(p)
#else
#define INLINE static __forceinline
#define UNROLL
#define AHEAD(p)
#endif

#define JOIN_NAMES(name, set) name##_##set
#define JOIN(name, set) JOIN_NAMES(name, set)
