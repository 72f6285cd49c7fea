/* Solves with the factor of the kernels of tiles.h: vectors instead of matrices.
 *
 * Included by tiles.h with its macros. A few columns are read once, so the loops avoid that
 * dependent additions or horizontal sums limit the memory bandwidth.
 */

/* y = -x b, x of shape (r, k); y is padded like the rows of x */
static void F(multiply)(ptrdiff_t r, ptrdiff_t k, const T *x, ptrdiff_t ldx, const T *b, T *y) {
    ptrdiff_t i;
    int rv;
    const int nc = 1;
    for (i = 0; i < r; i += rv * W) {
        rv = F(vectors)(r - i);
        if (rv == RV) F(negative)(RV, nc, k, x + i, ldx, b, 1, y + i, 0);
        else if (rv == 2) F(negative)(2, nc, k, x + i, ldx, b, 1, y + i, 0);
        else F(negative)(1, nc, k, x + i, ldx, b, 1, y + i, 0);
    }
}

/* Sums along vectors, by a tree of shuffles: FOLD_g takes two vectors in which g lanes belong to a
 * sum and makes one in which g / 2 do. */
#if VB
#if defined(__clang__)
#define SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (F(lanes)){__VA_ARGS__})
#endif
#if VB / BYTES == 2
#define FOLD_2(a, b) (SHUFFLE(a, b, 0, 2) + SHUFFLE(a, b, 1, 3))
#elif VB / BYTES == 4
#define FOLD_4(a, b) (SHUFFLE(a, b, 0, 1, 4, 5) + SHUFFLE(a, b, 2, 3, 6, 7))
#define FOLD_2(a, b) (SHUFFLE(a, b, 0, 2, 4, 6) + SHUFFLE(a, b, 1, 3, 5, 7))
#elif VB / BYTES == 8
#define FOLD_8(a, b) \
    (SHUFFLE(a, b, 0, 1, 2, 3, 8, 9, 10, 11) + SHUFFLE(a, b, 4, 5, 6, 7, 12, 13, 14, 15))
#define FOLD_4(a, b) \
    (SHUFFLE(a, b, 0, 1, 4, 5, 8, 9, 12, 13) + SHUFFLE(a, b, 2, 3, 6, 7, 10, 11, 14, 15))
#define FOLD_2(a, b) \
    (SHUFFLE(a, b, 0, 2, 4, 6, 8, 10, 12, 14) + SHUFFLE(a, b, 1, 3, 5, 7, 9, 11, 13, 15))
#else
#define FOLD_16(a, b) \
    (SHUFFLE(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) \
     + SHUFFLE(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31))
#define FOLD_8(a, b) \
    (SHUFFLE(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27) \
     + SHUFFLE(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31))
#define FOLD_4(a, b) \
    (SHUFFLE(a, b, 0, 1, 4, 5, 8, 9, 12, 13, 16, 17, 20, 21, 24, 25, 28, 29) \
     + SHUFFLE(a, b, 2, 3, 6, 7, 10, 11, 14, 15, 18, 19, 22, 23, 26, 27, 30, 31))
#define FOLD_2(a, b) \
    (SHUFFLE(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30) \
     + SHUFFLE(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31))
#endif
#endif

/* sums[j] = sum of the lanes of acc[j], for nc columns; the array has NC + 1 vectors */
INLINE void F(fold)(const int nc, const V *acc, T *sums) {
#if !VB
    int j;
    UNROLL
    for (j = 0; j < nc; j++) sums[j] = acc[j];
#else
    const V none = (V){0};
#define AT(j) (j < nc ? acc[j] : none)
#if VB / BYTES == 2
    *(V *)sums = FOLD_2(AT(0), AT(1));
    if (nc > 2) *(V *)(sums + 2) = FOLD_2(AT(2), AT(3));
    if (nc > 4) *(V *)(sums + 4) = FOLD_2(AT(4), AT(5));
#elif VB / BYTES == 4
    const V a = FOLD_4(AT(0), AT(1)), b = FOLD_4(AT(2), AT(3)), c = FOLD_4(AT(4), AT(5));
    *(V *)sums = FOLD_2(a, b);
    if (nc > 4) *(V *)(sums + 4) = FOLD_2(c, none);
#elif VB / BYTES == 8
    const V a = FOLD_8(AT(0), AT(1)), b = FOLD_8(AT(2), AT(3)), c = FOLD_8(AT(4), AT(5));
    const V d = FOLD_4(a, b), e = FOLD_4(c, none);
    *(V *)sums = FOLD_2(d, e);
#else
    const V a = FOLD_16(AT(0), AT(1)), b = FOLD_16(AT(2), AT(3)), c = FOLD_16(AT(4), AT(5));
    const V d = FOLD_8(a, b), e = FOLD_8(c, none);
    const V f = FOLD_4(d, e);
    *(V *)sums = FOLD_2(f, none);
#endif
#undef AT
#endif
}
#define FOLDED (NC + 64 / BYTES)

/* acc[j] += column j of x times y over whole vectors of up to r rows; returns the end */
INLINE ptrdiff_t F(along)(const int nc, ptrdiff_t r, const T *x, ptrdiff_t ldx, const T *y,
                               V *acc) {
    ptrdiff_t i = 0;
    int j;
    for (; i + W <= r; i += W) {
        const V t = *(const V *)(y + i);
        UNROLL
        for (j = 0; j < nc; j++) acc[j] += *(const V *)(x + i + j * ldx) * t;
    }
    return i;
}

/* b[j] -= column j of x times y over r rows, for nc columns */
INLINE void F(dots)(const int nc, ptrdiff_t r, const T *x, ptrdiff_t ldx, const T *y, T *b) {
    V acc[NC];
    T sums[FOLDED];
    ptrdiff_t i, w;
    int j;
    UNROLL
    for (j = 0; j < nc; j++) acc[j] = (V){0};
    i = F(along)(nc, r, x, ldx, y, acc);
    F(fold)(nc, acc, sums);
    for (w = i; w < r; w++) {
        UNROLL
        for (j = 0; j < nc; j++) sums[j] += x[w + j * ldx] * y[w];
    }
    UNROLL
    for (j = 0; j < nc; j++) b[j] -= sums[j];
}

/* b = b - c x for n rows of six columns */
INLINE void F(six)(ptrdiff_t n, const T *c, ptrdiff_t ld, const T *x, T *b) {
    const T x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3], x4 = x[4], x5 = x[5];
    ptrdiff_t i = 0;
#define SIX(K)                                                                                   \
    *(K *)(b + i) -= (*(const K *)(c + i) * x0 + *(const K *)(c + i + ld) * x1)                  \
                     + (*(const K *)(c + i + 2 * ld) * x2 + *(const K *)(c + i + 3 * ld) * x3)   \
                     + (*(const K *)(c + i + 4 * ld) * x4 + *(const K *)(c + i + 5 * ld) * x5)
    for (; i + W <= n; i += W) SIX(V);
#if VB >= 64
    if (n - i >= W / 2) { SIX(F(half)); i += W / 2; }
#endif
#if VB >= 32
    if (n - i >= (ptrdiff_t)(16 / sizeof(T))) { SIX(F(quarter)); i += 16 / sizeof(T); }
#endif
    for (; i < n; i++) SIX(T);
#undef SIX
}

/* b = b - x' y, x of shape (r, k) */
static void F(transposed)(ptrdiff_t r, ptrdiff_t k, const T *x, ptrdiff_t ldx, const T *y, T *b) {
    ptrdiff_t j0;
    for (j0 = 0; j0 < k; j0 += NC) {
        switch (k - j0) {
        case 5: F(dots)(5, r, x + j0 * ldx, ldx, y, b + j0); break;
        case 4: F(dots)(4, r, x + j0 * ldx, ldx, y, b + j0); break;
        case 3: F(dots)(3, r, x + j0 * ldx, ldx, y, b + j0); break;
        case 2: F(dots)(2, r, x + j0 * ldx, ldx, y, b + j0); break;
        case 1: F(dots)(1, r, x + j0 * ldx, ldx, y, b + j0); break;
        default: F(dots)(6, r, x + j0 * ldx, ldx, y, b + j0);
        }
    }
}

/* b = l^-1 b with the factor of `potrf` */
static void F(forward)(ptrdiff_t n, ptrdiff_t height, const T *l, ptrdiff_t ld, const T *inverse,
                       T *b) {
    ptrdiff_t j0, j, i, end;
    for (j0 = 0; j0 < n; j0 += NC) {
        const ptrdiff_t stop = n - j0 < NC ? n : j0 + NC;
        for (j = j0; j < stop; j++) {
            b[j] *= inverse[j];
            for (i = j + 1; i < stop; i++) b[i] -= l[i + j * ld] * b[j];
        }
        end = stop - 1 + height < n ? stop - 1 + height : n;
        if (stop - j0 == NC && end > stop)
            F(six)(end - stop, l + stop + j0 * ld, ld, b + j0, b + stop);
    }
}

/* b = l^-T b with the factor of `potrf` */
static void F(backward)(ptrdiff_t n, ptrdiff_t height, const T *l, ptrdiff_t ld, const T *inverse,
                        T *b) {
    ptrdiff_t j0, j, i, end;
    if (n <= 0) return;
    for (j0 = (n - 1) / NC * NC; j0 >= 0; j0 -= NC) {
        const ptrdiff_t stop = n - j0 < NC ? n : j0 + NC;
        end = stop - 1 + height < n ? stop - 1 + height : n;
        if (end > stop)
            F(transposed)(end - stop, stop - j0, l + stop + j0 * ld, ld, b + stop, b + j0);
        for (j = stop - 1; j >= j0; j--) {
            for (i = j + 1; i < stop; i++) b[j] -= l[i + j * ld] * b[i];
            b[j] *= inverse[j];
        }
    }
}

/* to = from for a column of h scalars, in the way of `add` */
INLINE void F(copy)(ptrdiff_t h, const T *from, T *to) {
    ptrdiff_t i = 0;
    for (; i + W <= h; i += W) *(V *)(to + i) = *(const V *)(from + i);
#if VB >= 64
    if (h - i >= W / 2) { *(F(half) *)(to + i) = *(const F(half) *)(from + i); i += W / 2; }
#endif
#if VB >= 32
    if (h - i >= (ptrdiff_t)(16 / sizeof(T))) {
        *(F(quarter) *)(to + i) = *(const F(quarter) *)(from + i);
        i += 16 / sizeof(T);
    }
#endif
    for (; i < h; i++) to[i] = from[i];
}

#if VB
/* From index W - n on: n lanes of ones, the rest zeros. */
static const INTEGER F(mask)[2 * (VB / BYTES)] __attribute__((aligned(64))) = {
    -1, -1,
#if VB / BYTES >= 4
    -1, -1,
#endif
#if VB / BYTES >= 8
    -1, -1, -1, -1,
#endif
#if VB / BYTES >= 16
    -1, -1, -1, -1, -1, -1, -1, -1,
#endif
};
#endif

/* The nc columns from j0 on of `ascend`: z of them from y, the rows of the panel, and from z
 * of the columns behind. */
INLINE void F(ascend_block)(const int nc, ptrdiff_t j0, ptrdiff_t k, ptrdiff_t rows,
                                 const T *triangle, ptrdiff_t ldt, const T *panel, ptrdiff_t ldp,
                                 const T *inverse, const T *y, T *z) {
    const T *d = triangle + j0 * (ldt + 1), *below = d + nc;
    const T *behind = z + j0 + nc;
    V acc[NC];
    T t[FOLDED];
    ptrdiff_t left = k - j0 - nc, at;
    int i, j;
    UNROLL
    for (j = 0; j < nc; j++) acc[j] = (V){0};
    F(along)(nc, rows, panel + j0 * ldp, ldp, y, acc);
    at = F(along)(nc, left, below, ldt, behind, acc);
#if VB
    if (at < left) {
        /* The data after the last row does not belong to this matrix. */
        const F(lanes) kept = *(const F(lanes) *)(F(mask) + W - (left - at));
        const V v = *(const V *)(behind + at);
        UNROLL
        for (j = 0; j < nc; j++)
            acc[j] += (V)(*(const F(lanes) *)(below + at + j * ldt) & kept) * v;
    }
#endif
    F(fold)(nc, acc, t);
    UNROLL
    for (j = nc - 1; j >= 0; j--) {
        T s = -t[j];
        UNROLL
        for (i = nc - 1; i > j; i--) s -= d[i + j * ldt] * t[i];
        t[j] = s * inverse[j0 + j];
    }
    UNROLL
    for (j = 0; j < nc; j++) z[j0 + j] = t[j];
}

/* own = l^-T (t - p' x) for a front of k columns: l its triangle, p its panel of r rows, t row r of
 * the panel. Strips (first, count) give the rows in x. */
static void F(ascend)(const int *strips, ptrdiff_t count, ptrdiff_t r, ptrdiff_t k,
                      const T *triangle, ptrdiff_t ldt, const T *panel, ptrdiff_t ldp,
                      const T *inverse, const T *x, T *own, T *work) {
    const ptrdiff_t rows = (r + W) / W * W;
    T *y = work, *z = work + ldp;
    ptrdiff_t i, j0;
    if (k <= 0) return;
    for (; count > 0; count--, strips += 2) {
        F(copy)(strips[1], x + strips[0], y);
        y += strips[1];
    }
    y = work;
    y[r] = -1;
    for (i = r + 1; i < rows; i++) y[i] = 0;
    for (i = k; i < (k + W - 1) / W * W + W; i++) z[i] = 0;
    j0 = (k - 1) / NC * NC;
#define BLOCK(nc) \
    F(ascend_block)(nc, j0, k, rows, triangle, ldt, panel, ldp, inverse, y, z)
    switch (k - j0) {
    case 6: BLOCK(6); break;
    case 5: BLOCK(5); break;
    case 4: BLOCK(4); break;
    case 3: BLOCK(3); break;
    case 2: BLOCK(2); break;
    default: BLOCK(1);
    }
    for (j0 -= NC; j0 >= 0; j0 -= NC) BLOCK(NC);
#undef BLOCK
    F(copy)(k, z, own);
}

#undef FOLDED
#undef SHUFFLE
#undef FOLD_16
#undef FOLD_8
#undef FOLD_4
#undef FOLD_2
