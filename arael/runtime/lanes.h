/* What all generated kernels share: columns of lanes to rows, large products.
 *
 * A generated module defines ARAEL_SINGLE for f32, and ARAEL_LARGE if a kernel of it is in parts,
 * and includes this once. Lanes and columns are explained in docs/internals/compiler.md.
 */

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef ARAEL_SINGLE
typedef float arael_real;
typedef int arael_integer;
#define ARAEL_F(name) name##f
#define ARAEL_LANES 16
#define ARAEL_TILE 8
#else
typedef double arael_real;
typedef long long arael_integer;
#define ARAEL_F(name) name
#define ARAEL_LANES 8
#define ARAEL_TILE 4
#endif

/* Whether the C library has vector forms of its functions (glibc's libmvec): the first of them came
   with 2.22, others with 2.35. A module declares those that it uses. */
#if defined(__GLIBC__) && defined(__x86_64__) && defined(ARAEL_LIBMVEC)
#define ARAEL_VECTORS_2_22
#if __GLIBC_PREREQ(2, 35)
#define ARAEL_VECTORS_2_35
#endif
#endif

#if defined(__GNUC__) || defined(__clang__)
#define fetch(at) __builtin_prefetch((at), 1)
#else
#define fetch(at) ((void)0)
#endif

/* Columns of lanes as rows: at[w][k] += q[k][w], or = if not `adds`. Compilers make single scalars
   of the plain loops, through memory; tiles stay in 256-bit registers, which are as fast as wider
   ones and there on every processor with AVX. Each step swaps between rows 1, 2 and (f32) 4 apart. */
#if defined(__AVX__) && (defined(__GNUC__) || defined(__clang__))
#if defined(__clang__)
#define ARAEL_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define ARAEL_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (arael_order){__VA_ARGS__})
#endif
#define ARAEL_UNROLL _Pragma("GCC unroll 8")
typedef arael_real arael_row __attribute__((vector_size(32)));
typedef arael_real arael_half __attribute__((vector_size(16)));
typedef arael_integer arael_order __attribute__((vector_size(32)));
static inline __attribute__((always_inline)) void move_rows(
    ptrdiff_t count, const arael_real *q, arael_real *const *at, int adds) {
    ptrdiff_t k, w;
    int i;
    for (k = 0; k < count; k += ARAEL_TILE)
        for (w = 0; w < ARAEL_LANES; w += ARAEL_TILE) {
            arael_row a[ARAEL_TILE], b[ARAEL_TILE];
            ARAEL_UNROLL
            for (i = 0; i < ARAEL_TILE; i++)
                memcpy(&a[i], q + (k + i) * ARAEL_LANES + w, sizeof(arael_row));
#ifdef ARAEL_SINGLE
            ARAEL_UNROLL
            for (i = 0; i < 8; i++)
                if (!(i & 1)) {
                    b[i] = ARAEL_SHUFFLE(a[i], a[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
                    b[i + 1] = ARAEL_SHUFFLE(a[i], a[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
                }
            ARAEL_UNROLL
            for (i = 0; i < 8; i++)
                if (!(i & 2)) {
                    a[i] = ARAEL_SHUFFLE(b[i], b[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
                    a[i + 2] = ARAEL_SHUFFLE(b[i], b[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
                }
            ARAEL_UNROLL
            for (i = 0; i < 8; i++)
                if (!(i & 4)) {
                    b[i] = ARAEL_SHUFFLE(a[i], a[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
                    b[i + 4] = ARAEL_SHUFFLE(a[i], a[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
                }
#define ARAEL_TURNED b
#define ARAEL_LOW(v) {v[0], v[1], v[2], v[3]}
#else
            ARAEL_UNROLL
            for (i = 0; i < 4; i++)
                if (!(i & 1)) {
                    b[i] = ARAEL_SHUFFLE(a[i], a[i + 1], 0, 4, 2, 6);
                    b[i + 1] = ARAEL_SHUFFLE(a[i], a[i + 1], 1, 5, 3, 7);
                }
            ARAEL_UNROLL
            for (i = 0; i < 4; i++)
                if (!(i & 2)) {
                    a[i] = ARAEL_SHUFFLE(b[i], b[i + 2], 0, 1, 4, 5);
                    a[i + 2] = ARAEL_SHUFFLE(b[i], b[i + 2], 2, 3, 6, 7);
                }
#define ARAEL_TURNED a
#define ARAEL_LOW(v) {v[0], v[1]}
#endif
            ARAEL_UNROLL
            for (i = 0; i < ARAEL_TILE; i++) {
                arael_real *h = at[w + i] + k;
                const arael_row v = ARAEL_TURNED[i];
                if (k + ARAEL_TILE <= count) {
                    arael_row sum = v;
                    if (adds) {
                        memcpy(&sum, h, sizeof(sum));
                        sum += v;
                    }
                    memcpy(h, &sum, sizeof(sum));
                } else {
                    ptrdiff_t j = 0;
                    if (count - k >= ARAEL_TILE / 2) {
                        const arael_half low = ARAEL_LOW(v);
                        arael_half sum = low;
                        if (adds) {
                            memcpy(&sum, h, sizeof(sum));
                            sum += low;
                        }
                        memcpy(h, &sum, sizeof(sum));
                        j = ARAEL_TILE / 2;
                    }
                    for (; j < count - k; j++) h[j] = adds ? h[j] + v[j] : v[j];
                }
            }
        }
}
#else
static void move_rows(ptrdiff_t count, const arael_real *q, arael_real *const *at, int adds) {
    ptrdiff_t k, w;
    for (w = 0; w < ARAEL_LANES; w++)
        for (k = 0; k < count; k++)
            at[w][k] = adds ? at[w][k] + q[k * ARAEL_LANES + w] : q[k * ARAEL_LANES + w];
}
#endif

#if defined(_MSC_VER)
#define ARAEL_APART __declspec(noinline)
#define ARAEL_INLINE __forceinline
#define ARAEL_RESTRICT __restrict
#else
#define ARAEL_APART __attribute__((noinline))
#define ARAEL_INLINE inline __attribute__((always_inline))
#define ARAEL_RESTRICT __restrict__
#endif

static ARAEL_APART void add_rows(ptrdiff_t count, const arael_real *q, arael_real *const *at) {
    move_rows(count, q, at, 1);
}
static ARAEL_APART void put_rows(ptrdiff_t count, const arael_real *q, arael_real *const *at) {
    move_rows(count, q, at, 0);
}

/* Type of Cython's functions that are compiled where they are called. */
#define arael_inlined ARAEL_INLINE void

#ifdef ARAEL_LARGE
/* Types of Cython's functions in which a part of a large kernel is compiled by itself. */
#define arael_part ARAEL_APART void
typedef arael_real *ARAEL_RESTRICT arael_columns;
typedef const arael_real *ARAEL_RESTRICT arael_data;

/* How the Jacobian of a constraint is filled.
 *
 * runs   {use, first scalar in the use, first entry, entries}: neighbours in one residual and use,
 *        by residual, use and scalar; those of residual k end at ends[k + 1]
 * width  scalars solved for, by use
 * leads  whether the use belongs to the lead, by use
 * coupled by pair of uses: whether a residual reads both
 */
typedef struct {
    int residuals, entries, uses;
    const int (*runs)[4];
    const int *ends, *width, *leads, *coupled;
} arael_jacobian;

/* h[j] += sum over lanes of a[lane] row[lane][j]; rows are `stride` apart. */
static inline void arael_add_lanes(
    arael_real *ARAEL_RESTRICT h, const arael_real *ARAEL_RESTRICT a,
    const arael_real *ARAEL_RESTRICT row, ptrdiff_t stride, ptrdiff_t lanes, ptrdiff_t n) {
    ptrdiff_t w = 0, j;
    for (; w + 4 <= lanes; w += 4) {
        const arael_real a0 = a[w], a1 = a[w + 1], a2 = a[w + 2], a3 = a[w + 3];
        const arael_real *r0 = row + w * stride, *r1 = r0 + stride;
        const arael_real *r2 = r1 + stride, *r3 = r2 + stride;
        for (j = 0; j < n; j++) h[j] += (a0 * r0[j] + a1 * r1[j]) + (a2 * r2[j] + a3 * r3[j]);
    }
    for (; w < lanes; w++)
        for (j = 0; j < n; j++) h[j] += a[w] * row[w * stride + j];
}

/* Add J'r and J'J of `count` lanes.
 *
 * o      columns of lanes: the residuals, then the Jacobian's entries by residual, use and scalar
 * rows   workspace of `entries` x W
 * run    whether all lanes share the rows of the lead
 * The others are the fields of `Lanes` for this block of lanes.
 */
static ARAEL_APART void add_products(
    const arael_jacobian *p, const arael_real *o, arael_real *rows, ptrdiff_t count, int run,
    arael_real *gradient, arael_real *values, const int32_t *gradient_at, const int64_t *block_at,
    const uint8_t *turn, const uint8_t *first) {
    const ptrdiff_t stride = p->entries;
    const arael_real *jacobian = o + (ptrdiff_t)p->residuals * ARAEL_LANES;
    ptrdiff_t i, j, w, e;
    int k, s, t, a, b;
    for (e = 0; e < stride; e++)
        for (w = 0; w < count; w++) rows[w * stride + e] = jacobian[e * ARAEL_LANES + w];
    for (a = 0; a < p->uses; a++)
        for (b = 0; b < a; b++) {
            const ptrdiff_t pair = (ptrdiff_t)a * (a + 1) / 2 + b;
            if (!p->coupled[pair] || !first[pair]) continue;
            for (w = 0; w < count; w++)
                memset(values + block_at[pair * ARAEL_LANES + w], 0,
                       sizeof(arael_real) * p->width[a] * p->width[b]);
        }
    for (k = 0; k < p->residuals; k++)
        for (s = p->ends[k]; s < p->ends[k + 1]; s++) {
            const int *left = p->runs[s];
            const arael_real *r = o + (ptrdiff_t)k * ARAEL_LANES;
            a = left[0];
            if (run && p->leads[a])
                arael_add_lanes(gradient + gradient_at[a * ARAEL_LANES] + left[1], r,
                                rows + left[2], stride, count, left[3]);
            else
                for (w = 0; w < count; w++)
                    arael_add_lanes(gradient + gradient_at[a * ARAEL_LANES + w] + left[1], r + w,
                                    rows + w * stride + left[2], stride, 1, left[3]);
            for (t = p->ends[k]; t <= s; t++) {
                const int *right = p->runs[t];
                b = right[0];
                const ptrdiff_t pair = (ptrdiff_t)a * (a + 1) / 2 + b;
                const ptrdiff_t high = p->width[a], wide = p->width[b];
                const int together =
                    run && p->leads[a] && p->leads[b] && turn[pair * ARAEL_LANES] != 2;
                for (w = 0; w < count; w += together ? count : 1) {
                    arael_real *h = values + block_at[pair * ARAEL_LANES + w];
                    const int way = turn[pair * ARAEL_LANES + w];
                    const ptrdiff_t lanes = together ? count : 1;
                    const arael_real *x = rows + w * stride;
                    if (way == 0)
                        for (i = 0; i < left[3]; i++)
                            arael_add_lanes(h + (left[1] + i) * wide + right[1],
                                            jacobian + (left[2] + i) * ARAEL_LANES + w,
                                            x + right[2], stride, lanes,
                                            s == t ? i + 1 : right[3]);
                    else if (way == 1)
                        for (j = 0; j < right[3]; j++)
                            arael_add_lanes(h + (right[1] + j) * high + left[1],
                                            jacobian + (right[2] + j) * ARAEL_LANES + w,
                                            x + left[2], stride, lanes, left[3]);
                    else
                        for (i = 0; i < left[3]; i++)
                            for (j = 0; j < right[3]; j++) {
                                const ptrdiff_t row = left[1] + i, column = right[1] + j;
                                const arael_real v = x[left[2] + i] * x[right[2] + j];
                                h[(row > column ? row : column) * wide +
                                  (row > column ? column : row)] += row == column ? 2 * v : v;
                            }
                }
            }
        }
}
#endif
