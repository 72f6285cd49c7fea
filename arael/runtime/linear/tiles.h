/* Dense kernels for the panels of a Cholesky factor, on tiles that stay in vector registers.
 *
 * Included by tiles.c once per scalar type T; F(x) is the name of function x for that type, VB the
 * bytes of a vector (0: plain scalars), RV the vectors of rows in a tile. All matrices are column-major. A tile is RV vectors of rows by up to NC columns; NC is
 * 6, so that the blocks of 3 and 6 of poses and points fill tiles exactly. Rows are padded by the
 * callers: a kernel may touch up to one vector beyond the last row. Large matrices are processed by
 * blocks, TILE_BLOCK columns of one operand by a depth of TILE_DEPTH: multiples of the rows and
 * columns of any tile. So is TILE_PIECE: work may be split there without changing any result.
 */
#ifndef TILE_BLOCK
#define TILE_BLOCK 96
#define TILE_DEPTH 240
#define TILE_PIECE 48
#endif

#if VB
typedef T F(vec) __attribute__((vector_size(VB), aligned(sizeof(T)), may_alias));
#define W ((ptrdiff_t)(VB / sizeof(T)))
#else
typedef T F(vec);
#define W ((ptrdiff_t)1)
#endif
#define V F(vec)
#if VB
/* Integers of the width of scalars: masks and indices of shuffles. */
typedef INTEGER F(lanes) __attribute__((vector_size(VB), aligned(sizeof(T)), may_alias));
#endif
#if VB >= 64
typedef T F(half) __attribute__((vector_size(32), aligned(sizeof(T)), may_alias));
#endif
#if VB >= 32
typedef T F(quarter) __attribute__((vector_size(16), aligned(sizeof(T)), may_alias));
#endif

/* acc[j][i] = sum over p of rows i of column p of `a` times entry j of column p of `b` */
INLINE void F(product)(const int rv, const int nc, ptrdiff_t depth, const T *a, ptrdiff_t lda,
                            const T *b, ptrdiff_t ldb, V acc[NC][RV]) {
    int i, j;
    UNROLL
    for (j = 0; j < nc; j++) {
        UNROLL
        for (i = 0; i < rv; i++) acc[j][i] = (V){0};
    }
    for (; depth > 0; depth--, a += lda, b += ldb) {
        V x[RV];
        UNROLL
        for (i = 0; i < rv; i++) x[i] = *(const V *)(a + i * W);
        UNROLL
        for (j = 0; j < nc; j++) {
            UNROLL
            for (i = 0; i < rv; i++) acc[j][i] += x[i] * b[j];
        }
    }
}

/* c = -a b', for `rows` rv W and columns nc */
INLINE void F(negative)(const int rv, const int nc, ptrdiff_t depth, const T *a, ptrdiff_t lda,
                             const T *b, ptrdiff_t ldb, T *c, ptrdiff_t ldc) {
    V acc[NC][RV];
    int i, j;
    F(product)(rv, nc, depth, a, lda, b, ldb, acc);
    UNROLL
    for (j = 0; j < nc; j++) {
        UNROLL
        for (i = 0; i < rv; i++) *(V *)(c + i * W + j * ldc) = -acc[j][i];
    }
}

/* c = c - a b' */
INLINE void F(subtract)(const int rv, const int nc, ptrdiff_t depth, const T *a, ptrdiff_t lda,
                             const T *b, ptrdiff_t ldb, T *c, ptrdiff_t ldc) {
    V acc[NC][RV];
    int i, j;
    F(product)(rv, nc, depth, a, lda, b, ldb, acc);
    UNROLL
    for (j = 0; j < nc; j++) {
        UNROLL
        for (i = 0; i < rv; i++) *(V *)(c + i * W + j * ldc) -= acc[j][i];
    }
}

/* c = (c - a b') d^-T with d a lower triangle, 1 / its diagonal in `inverse` */
INLINE void F(divide)(const int rv, const int nc, ptrdiff_t depth, const T *a, ptrdiff_t lda,
                           const T *b, ptrdiff_t ldb, const T *d, ptrdiff_t ldd, const T *inverse,
                           T *c, ptrdiff_t ldc) {
    V acc[NC][RV];
    int i, j, l;
    F(product)(rv, nc, depth, a, lda, b, ldb, acc);
    UNROLL
    for (j = 0; j < nc; j++) {
        UNROLL
        for (i = 0; i < rv; i++) acc[j][i] = *(const V *)(c + i * W + j * ldc) - acc[j][i];
        UNROLL
        for (l = 0; l < j; l++) {
            UNROLL
            for (i = 0; i < rv; i++) acc[j][i] -= acc[l][i] * d[j + l * ldd];
        }
        UNROLL
        for (i = 0; i < rv; i++) acc[j][i] *= inverse[j];
        UNROLL
        for (i = 0; i < rv; i++) *(V *)(c + i * W + j * ldc) = acc[j][i];
    }
}

/* Call f with constants for rv in 1..RV and nc in 1..6. */
#define TILE_COLUMNS(f, rv, ...)                    \
    switch (nc) {                                   \
    case 6: f(rv, 6, __VA_ARGS__); break;           \
    case 5: f(rv, 5, __VA_ARGS__); break;           \
    case 4: f(rv, 4, __VA_ARGS__); break;           \
    case 3: f(rv, 3, __VA_ARGS__); break;           \
    case 2: f(rv, 2, __VA_ARGS__); break;           \
    default: f(rv, 1, __VA_ARGS__);                 \
    }
#if RV >= 3
#define TILE_SIZES(f, ...)                                  \
    if (rv >= 3) { TILE_COLUMNS(f, 3, __VA_ARGS__) }        \
    else if (rv == 2) { TILE_COLUMNS(f, 2, __VA_ARGS__) }   \
    else { TILE_COLUMNS(f, 1, __VA_ARGS__) }
#else
#define TILE_SIZES(f, ...)                                  \
    if (rv >= 2) { TILE_COLUMNS(f, 2, __VA_ARGS__) }        \
    else { TILE_COLUMNS(f, 1, __VA_ARGS__) }
#endif

/* Vectors of the next tile for `rows` remaining rows. */
static inline int F(vectors)(ptrdiff_t rows) {
    ptrdiff_t v = (rows + W - 1) / W;
    return v < RV ? (int)v : RV;
}

/* Factor of the nc x nc matrix d into `factor` (leading dimension NC); 0 or 1 + failing pivot.
 *
 * Computed as L D L' first, so that the dependency chain between pivots contains no square roots;
 * the columns are multiplied by the roots of D at the end. */
INLINE int F(pivot_block)(const int nc, const T *d, ptrdiff_t ldd, T *factor, T *inverse) {
    T a[NC][NC], pivot[NC];
    int i, j, l, failed = 0;
    UNROLL
    for (j = 0; j < nc; j++) {
        UNROLL
        for (i = j; i < nc; i++) a[j][i] = d[i + j * ldd];
    }
    UNROLL
    for (j = 0; j < nc; j++) {
        const T part = 1 / a[j][j];
        pivot[j] = a[j][j];
        UNROLL
        for (l = j + 1; l < nc; l++) {
            const T t = a[j][l] * part;
            UNROLL
            for (i = l; i < nc; i++) a[l][i] -= a[j][i] * t;
        }
    }
    UNROLL
    for (j = nc - 1; j >= 0; j--) {
        /* NaN fails the first comparison, infinity the second. */
        if (!(pivot[j] > 0 && pivot[j] <= LARGEST)) failed = j + 1;
    }
    if (failed) return failed;
    UNROLL
    for (j = 0; j < nc; j++) inverse[j] = 1 / SQRT(pivot[j]);
    UNROLL
    for (j = 0; j < nc; j++) {
        UNROLL
        for (i = j; i < nc; i++) factor[i + j * NC] = a[j][i] * inverse[j];
    }
    return 0;
}

static int F(pivots)(int nc, const T *d, ptrdiff_t ldd, T *factor, T *inverse) {
    switch (nc) {
    case 6: return F(pivot_block)(6, d, ldd, factor, inverse);
    case 5: return F(pivot_block)(5, d, ldd, factor, inverse);
    case 4: return F(pivot_block)(4, d, ldd, factor, inverse);
    case 3: return F(pivot_block)(3, d, ldd, factor, inverse);
    case 2: return F(pivot_block)(2, d, ldd, factor, inverse);
    default: return F(pivot_block)(1, d, ldd, factor, inverse);
    }
}

/* First column in which all rows up to the ends of both operands may be addressed. */
static inline ptrdiff_t F(first)(ptrdiff_t end, ptrdiff_t other, ptrdiff_t reach) {
    const ptrdiff_t p = (end > other ? end : other) - 1 - reach;
    return p > 0 ? p : 0;
}

/* Cholesky factor in place of a symmetric matrix of which only a band is stored or touched.
 *
 * Entry (i, j) is at l[i + j ld]. `height` rows from the diagonal on may be non-zero in a column
 * (the diagonal counts; n or more: dense) and `reach` rows below the diagonal may be addressed and
 * are zero beyond the band. 1 / diagonal goes to `inverse`. Returns 0 or 1 + the failing pivot.
 * Up to NC - 1 entries above the diagonal are overwritten: in a band they alias the rows that many
 * places before ld below the diagonal of the column before, so there reach is at most ld - NC.
 */
static ptrdiff_t F(potrf_near)(ptrdiff_t n, ptrdiff_t height, ptrdiff_t reach, T *l, ptrdiff_t ld,
                               T *inverse) {
    ptrdiff_t j0, i, end, first;
    T factor[NC * NC] = {0};
    for (j0 = 0; j0 < n; j0 += NC) {
        const int nc = n - j0 < NC ? (int)(n - j0) : NC;
        T *column = l + j0 * ld;
        int rv, status;
        end = j0 + nc - 1 + height < n ? j0 + nc - 1 + height : n;
        for (i = j0; i < j0 + nc; i += W) {
            rv = 1;
            first = F(first)(i + W, j0 + nc, reach);
            TILE_COLUMNS(F(subtract), 1, j0 - first, l + i + first * ld, ld, l + j0 + first * ld,
                         ld, column + i, ld)
        }
        status = F(pivots)(nc, column + j0, ld, factor, inverse + j0);
        if (status) return j0 + status;
        for (i = j0; i < j0 + nc; i += W) {
            TILE_COLUMNS(F(divide), 1, 0, l, ld, l, ld, factor, NC, inverse + j0, column + i, ld)
        }
        for (; i < end; i += rv * W) {
            rv = F(vectors)(end - i);
            first = F(first)(i + rv * W, j0 + nc, reach);
            TILE_SIZES(F(divide), j0 - first, l + i + first * ld, ld, l + j0 + first * ld, ld,
                       factor, NC, inverse + j0, column + i, ld)
        }
    }
    return 0;
}

/* c = c - a b' for m x n entries of c and depth k; if `lower` only tiles on or below the diagonal.
   Processed by blocks of b that stay in the second-level cache. Rows before `begin`, a multiple of
   TILE_PIECE, are skipped. */
static void F(lessen)(ptrdiff_t begin, ptrdiff_t m, ptrdiff_t n, ptrdiff_t k, const T *a,
                      ptrdiff_t lda, const T *b, ptrdiff_t ldb, T *c, ptrdiff_t ldc, int lower) {
    ptrdiff_t jb, i0, i, j0, end;
    int rv, nc, tile;
    for (jb = 0; jb < n; jb += TILE_BLOCK) {
        for (i0 = lower && jb > begin ? jb : begin; i0 < m; i0 += tile * W) {
            tile = F(vectors)(m - i0);
            end = n - jb < TILE_BLOCK ? n : jb + TILE_BLOCK;
            if (lower && end > i0 + tile * W) end = i0 + tile * W;
            for (j0 = jb; j0 < end; j0 += NC) {
                nc = n - j0 < NC ? (int)(n - j0) : NC;
                i = lower && j0 > i0 ? i0 + (j0 - i0) / W * W : i0;
                rv = tile - (int)((i - i0) / W);
                TILE_SIZES(F(subtract), k, a + i, lda, b + j0, ldb, c + i + j0 * ldc, ldc)
            }
        }
    }
}

/* x = x l^-T, x of shape (r, k), for k so small that l stays in the second-level cache */
static void F(trsm_near)(ptrdiff_t r, ptrdiff_t k, const T *l, ptrdiff_t ld, const T *inverse, T *x,
                         ptrdiff_t ldx) {
    ptrdiff_t i, j0;
    int rv, nc;
    for (i = 0; i < r; i += rv * W) {
        rv = F(vectors)(r - i);
        for (j0 = 0; j0 < k; j0 += NC) {
            nc = k - j0 < NC ? (int)(k - j0) : NC;
            TILE_SIZES(F(divide), j0, x + i, ldx, l + j0, ld, l + j0 + j0 * ld, ld, inverse + j0,
                       x + i + j0 * ldx, ldx)
        }
    }
}

/* x = x l^-T, x of shape (r, k) */
static void F(trsm)(ptrdiff_t r, ptrdiff_t k, const T *l, ptrdiff_t ld, const T *inverse, T *x,
                    ptrdiff_t ldx) {
    ptrdiff_t j;
    if (k <= 2 * TILE_DEPTH) {
        F(trsm_near)(r, k, l, ld, inverse, x, ldx);
        return;
    }
    for (j = 0; j < k; j += TILE_DEPTH) {
        const ptrdiff_t kb = k - j < TILE_DEPTH ? k - j : TILE_DEPTH;
        F(trsm_near)(r, kb, l + j * (ld + 1), ld, inverse + j, x + j * ldx, ldx);
        F(lessen)(0, r, k - j - kb, kb, x + j * ldx, ldx, l + j + kb + j * ld, ld,
                  x + (j + kb) * ldx, ldx, 0);
    }
}

/* Rows `begin`, a multiple of TILE_PIECE, to r of the n first columns of the lower triangle of
 * u = -x x', x of shape (r, k); entries above the diagonal are overwritten. */
static void F(syrk)(ptrdiff_t begin, ptrdiff_t r, ptrdiff_t n, ptrdiff_t k, const T *x,
                    ptrdiff_t ldx, T *u, ptrdiff_t ldu) {
    const ptrdiff_t near = k < TILE_DEPTH + TILE_DEPTH / 2 ? k : TILE_DEPTH;
    ptrdiff_t jb, i0, i, j0, end;
    int rv, nc, tile;
    for (jb = 0; jb < n; jb += TILE_BLOCK) {
        for (i0 = jb > begin ? jb : begin; i0 < r; i0 += tile * W) {
            tile = F(vectors)(r - i0);
            end = n - jb < TILE_BLOCK ? n : jb + TILE_BLOCK;
            if (end > i0 + tile * W) end = i0 + tile * W;
            for (j0 = jb; j0 < end; j0 += NC) {
                nc = n - j0 < NC ? (int)(n - j0) : NC;
                i = j0 > i0 ? i0 + (j0 - i0) / W * W : i0;
                rv = tile - (int)((i - i0) / W);
                TILE_SIZES(F(negative), near, x + i, ldx, x + j0, ldx, u + i + j0 * ldu, ldu)
            }
        }
    }
    for (i = near; i < k; i += TILE_DEPTH) {
        const ptrdiff_t depth = k - i < TILE_DEPTH ? k - i : TILE_DEPTH;
        F(lessen)(begin, r, n, depth, x + i * ldx, ldx, x + i * ldx, ldx, u, ldu, 1);
    }
}

/* The factor of a dense matrix, as in `potrf_near`, by blocks of columns. */
static ptrdiff_t F(potrf)(ptrdiff_t n, ptrdiff_t height, ptrdiff_t reach, T *l, ptrdiff_t ld,
                          T *inverse) {
    /* A vector of rows below the corner, which the factorisation of the corner overshoots. */
    V kept[TILE_DEPTH];
    ptrdiff_t j, c;
    if (n <= 2 * TILE_DEPTH || height < n || reach < n * ld)
        return F(potrf_near)(n, height, reach, l, ld, inverse);
    for (j = 0; j < n; j += TILE_DEPTH) {
        const ptrdiff_t nb = n - j < TILE_DEPTH ? n - j : TILE_DEPTH, rest = n - j - nb;
        T *corner = l + j * (ld + 1), *below = corner + nb;
        ptrdiff_t status;
        if (rest > 0)
            for (c = 0; c < nb; c++) kept[c] = *(const V *)(below + c * ld);
        status = F(potrf_near)(nb, nb, reach, corner, ld, inverse + j);
        if (status) return j + status;
        if (rest == 0) break;
        for (c = 0; c < nb; c++) *(V *)(below + c * ld) = kept[c];
        F(trsm_near)(rest, nb, corner, ld, inverse + j, below, ld);
        F(lessen)(0, rest, rest, nb, below, ld, below, ld, corner + nb * (ld + 1), ld, 1);
    }
    return 0;
}

/* to += from for a column of h scalars: whole vectors, then smaller ones */
INLINE void F(add)(ptrdiff_t h, const T *from, T *to) {
    ptrdiff_t i = 0;
    for (; i + W <= h; i += W) *(V *)(to + i) += *(const V *)(from + i);
#if VB >= 64
    if (h - i >= W / 2) { *(F(half) *)(to + i) += *(const F(half) *)(from + i); i += W / 2; }
#endif
#if VB >= 32
    if (h - i >= (ptrdiff_t)(16 / sizeof(T))) {
        *(F(quarter) *)(to + i) += *(const F(quarter) *)(from + i);
        i += 16 / sizeof(T);
    }
#endif
    for (; i < h; i++) to[i] += from[i];
}

/* to += from for w columns of h scalars */
static void F(add_block)(ptrdiff_t h, ptrdiff_t w, const T *from, ptrdiff_t ldf, T *to,
                         ptrdiff_t ldt) {
    /* The blocks of planar and spatial poses, with unrolled loops. */
    if (h == 3)
        for (; w > 0; w--, from += ldf, to += ldt) F(add)(3, from, to);
    else if (h == 6)
        for (; w > 0; w--, from += ldf, to += ldt) F(add)(6, from, to);
    else
        for (; w > 0; w--, from += ldf, to += ldt) F(add)(h, from, to);
}

/* to += from for a row of w scalars */
INLINE void F(add_row)(ptrdiff_t w, const T *from, ptrdiff_t ldf, T *to, ptrdiff_t ldt) {
    for (; w > 0; w--, from += ldf, to += ldt) *to += *from;
}

/* Add to columns `begin` to `end` of a front the update matrix u of its child. Rows of the child
are mapped in runs (row, count, row in the parent); the runs up to `inside` are columns of the
parent,
 * its k first rows. The right-hand side is row `side` of u and row `own` of the parent's panel. */
static void F(extend_columns)(const int *runs, ptrdiff_t inside, ptrdiff_t count, ptrdiff_t k,
                              const T *u, ptrdiff_t ldu, T *triangle, ptrdiff_t ldt, T *panel,
                              ptrdiff_t ldp, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t side,
                              ptrdiff_t own) {
    ptrdiff_t a, b, q;
    for (a = 0; a < inside; a++) {
        const ptrdiff_t row = runs[3 * a], w = runs[3 * a + 1], to = runs[3 * a + 2];
        const ptrdiff_t first = begin > to ? begin - to : 0, last = end - to < w ? end - to : w;
        const T *from = u + row * ldu;
        if (first >= last) continue;
        for (q = first; q < last; q++)
            F(add)(w - q, from + row + q + q * ldu, triangle + (to + q) * (ldt + 1));
        from += first * ldu;
        for (b = a + 1; b < inside; b++)
            F(add_block)(runs[3 * b + 1], last - first, from + runs[3 * b], ldu,
                         triangle + runs[3 * b + 2] + (to + first) * ldt, ldt);
        for (; b < count; b++)
            F(add_block)(runs[3 * b + 1], last - first, from + runs[3 * b], ldu,
                         panel + runs[3 * b + 2] - k + (to + first) * ldp, ldp);
        F(add_row)(last - first, from + side, ldu, panel + own + (to + first) * ldp, ldp);
    }
}

/* The same for the columns of the parent's own update matrix. */
static void F(extend_update)(const int *runs, ptrdiff_t inside, ptrdiff_t count, ptrdiff_t k,
                             const T *u, ptrdiff_t ldu, T *update, ptrdiff_t ldp, ptrdiff_t begin,
                             ptrdiff_t end, ptrdiff_t side, ptrdiff_t own) {
    ptrdiff_t a, b, q;
    for (a = inside; a < count; a++) {
        const ptrdiff_t row = runs[3 * a], w = runs[3 * a + 1], to = runs[3 * a + 2] - k;
        const ptrdiff_t first = begin > to ? begin - to : 0, last = end - to < w ? end - to : w;
        const T *from = u + row * ldu;
        if (first >= last) continue;
        for (q = first; q < last; q++)
            F(add)(w - q, from + row + q + q * ldu, update + (to + q) * (ldp + 1));
        from += first * ldu;
        for (b = a + 1; b < count; b++)
            F(add_block)(runs[3 * b + 1], last - first, from + runs[3 * b], ldu,
                         update + runs[3 * b + 2] - k + (to + first) * ldp, ldp);
        F(add_row)(last - first, from + side, ldu, update + own + (to + first) * ldp, ldp);
    }
}

#include "sweeps.h"

#undef V
#undef W
#undef TILE_SIZES
#undef TILE_COLUMNS
