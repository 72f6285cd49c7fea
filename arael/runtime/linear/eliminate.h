/* Kernels that eliminate entities block by block. Included by eliminate.c, which defines the names.
 *
 * An eliminated entity e of d scalars has a diagonal block D = L L' and, for every kept entity i
 * that it is coupled with, a block W_i of d x s_i scalars. The kernels store L     d x d,
 * row-major, 1 / diagonal on the diagonal, Z_i = L^-1 W_i, d x s_i, row-major, the entity's blocks
 * one after the other, because the reduced system needs Z_i' Z_j = W_i' D^-1 W_j and nothing else.
 *
 * Vectors over the kept entities are padded, so that whole vectors can be read from any entity; Z
 * is followed by a cache line of padding.
 */

#if VB
typedef T F(wide) __attribute__((vector_size(VB), aligned(sizeof(T)), may_alias));
#define W ((int)(VB / sizeof(T)))
#else
typedef T F(wide);
#define W 1
#endif
#define V F(wide)
#if VB >= 64
typedef T F(half_wide) __attribute__((vector_size(32), aligned(sizeof(T)), may_alias));
#endif
#if VB >= 32
typedef T F(quarter_wide) __attribute__((vector_size(16), aligned(sizeof(T)), may_alias));
#endif

/* Do ONE(type, c) for pieces c of s columns: whole vectors, then smaller ones. */
#if VB >= 64
#define HALF_PIECE(ONE, s) if ((s) - c >= W / 2) { ONE(F(half_wide), c); c += W / 2; }
#else
#define HALF_PIECE(ONE, s)
#endif
#if VB >= 32
#define QUARTER_PIECE(ONE, s)                            \
    if ((s) - c >= (int)(16 / sizeof(T))) {              \
        ONE(F(quarter_wide), c);                         \
        c += (int)(16 / sizeof(T));                      \
    }
#else
#define QUARTER_PIECE(ONE, s)
#endif
#define PIECES(ONE, s)                                   \
    do {                                                 \
        int c = 0;                                       \
        for (; c + W <= (s); c += W) ONE(V, c);          \
        HALF_PIECE(ONE, s)                               \
        QUARTER_PIECE(ONE, s)                            \
        for (; c < (s); c++) ONE(T, c);                  \
    } while (0)

/* Factor of the d x d block with `diagonal` in place of its own; 0 or 1 + the failing pivot. */
INLINE int F(pivot_block)(const int d, const T *block, const T *diagonal, T *l) {
    int i, j, k;
    for (i = 0; i < d; i++) {
        T pivot = diagonal[i];
        for (j = 0; j < i; j++) {
            T s = block[i * d + j];
            for (k = 0; k < j; k++) s -= l[i * d + k] * l[j * d + k];
            s *= l[j * d + j];
            l[i * d + j] = s;
            pivot -= s * s;
        }
        /* NaN fails the first comparison, infinity the second. */
        if (!(pivot > 0 && pivot <= LARGEST)) return i + 1;
        l[i * d + i] = 1 / SQRT(pivot);
    }
    return 0;
}

/* z = l^-1 w for s columns */
INLINE void F(whiten)(const int d, const int s, const T *l, const T *w, T *z) {
    int i, k;
#define ONE(K, c)                                                                       \
    for (i = 0; i < d; i++) {                                                           \
        K x = *(const K *)(w + i * s + (c));                                            \
        for (k = 0; k < i; k++) x -= l[i * d + k] * *(const K *)(z + k * s + (c));      \
        *(K *)(z + i * s + (c)) = x * l[i * d + i];                                     \
    }
    PIECES(ONE, s);
#undef ONE
}

INLINE void F(whiten_all)(const int d, const Coupling *first, const Coupling *last,
                                 const T *l, const T *values, T *z) {
    const Coupling *o;
    int i, j;
    for (o = first; o < last; o++) {
        const T *w = values + o->source;
        T *to = z + o->place;
        const int s = o->width;
        const T *ahead = values + o[PAIRS_AHEAD].source;
        for (i = 0; i < d * s; i += 64 / sizeof(T)) AHEAD(ahead + i);
        if (o->turned) {
            for (j = 0; j < s; j++)
                for (i = 0; i < d; i++) to[i * s + j] = w[j * d + i];
            w = to;
        }
        switch (s) {
        case 3: F(whiten)(d, 3, l, w, to); break;
        case 6: F(whiten)(d, 6, l, w, to); break;
        case 9: F(whiten)(d, 9, l, w, to); break;
        default: F(whiten)(d, s, l, w, to);
        }
    }
}

/* Factor and Z of all entities; 0 or 1 + the scalar whose pivot failed. */
static ptrdiff_t F(eliminate)(ptrdiff_t count, const Entity *entities, const Coupling *couplings,
                              const T *values, const T *diagonal, T *factors, T *z) {
    ptrdiff_t e;
    for (e = 0; e < count; e++) {
        const Entity *at = entities + e;
        const Coupling *first = couplings + at->couplings, *last = couplings + at[1].couplings;
        const T *block = values + at->source, *own = diagonal + at->scalar;
        T *l = factors + at->factor;
        int failed;
        if (e + PAIRS_AHEAD < count) {
            AHEAD(values + at[PAIRS_AHEAD].source);
            AHEAD(diagonal + at[PAIRS_AHEAD].scalar);
        }
        switch (at->size) {
#define CASE(d)                                                             \
        case d:                                                             \
            failed = F(pivot_block)(d, block, own, l);                      \
            if (!failed) F(whiten_all)(d, first, last, l, values, z);       \
            break;
        CASE(1)
        CASE(2)
        CASE(3)
        CASE(6)
#undef CASE
        default:
            failed = F(pivot_block)(at->size, block, own, l);
            if (!failed) F(whiten_all)(at->size, first, last, l, values, z);
        }
        if (failed) return at->scalar + failed;
    }
    return 0;
}

/* Rows r0 to r0 + rn of the h x w block: block -= sum of Za' Zb. `vectors` of the block's columns
   are summed in registers, including padding, and `columns` of them are stored. */
INLINE void F(gram_rows)(const int d, const int h, const int w, const int r0, const int rn,
                         const int c0, const int vectors, const int columns, ptrdiff_t count,
                         const int *pairs, const T *z, T *block) {
    V acc[16][2];
    T out[2 * W] = {0};
    int r, c, k, v;
    UNROLL
    for (r = 0; r < rn; r++) {
        UNROLL
        for (v = 0; v < vectors; v++) acc[r][v] = (V){0};
    }
    for (; count > 0; count--, pairs += 2) {
        const T *a = z + pairs[0] + r0, *b = z + pairs[1] + c0;
        AHEAD(z + pairs[PAIRS_AHEAD]);
        AHEAD(z + pairs[PAIRS_AHEAD] + 64 / sizeof(T));
        AHEAD(z + pairs[PAIRS_AHEAD + 1]);
        AHEAD(z + pairs[PAIRS_AHEAD + 1] + 64 / sizeof(T));
        UNROLL
        for (k = 0; k < d; k++, a += h, b += w) {
            V x[2];
            UNROLL
            for (v = 0; v < vectors; v++) x[v] = *(const V *)(b + v * W);
            UNROLL
            for (r = 0; r < rn; r++) {
                UNROLL
                for (v = 0; v < vectors; v++) acc[r][v] += a[r] * x[v];
            }
        }
    }
    UNROLL
    for (r = 0; r < rn; r++) {
        UNROLL
        for (v = 0; v < vectors; v++) *(V *)(out + v * W) = acc[r][v];
        for (c = 0; c < columns; c++) block[(r0 + r) * w + c0 + c] -= out[c];
    }
}

/* The same for a square block with one column more than a vector: the last column is summed along
   the rows, with one remaining scalar. */
INLINE void F(gram_odd)(const int d, ptrdiff_t count, const int *pairs, const T *z, T *block) {
    const int n = W + 1;
    V acc[W + 1], last = (V){0};
    T corner = 0, out[W] = {0};
    int r, c, k;
    UNROLL
    for (r = 0; r < n; r++) acc[r] = (V){0};
    for (; count > 0; count--, pairs += 2) {
        const T *a = z + pairs[0], *b = z + pairs[1];
        AHEAD(z + pairs[PAIRS_AHEAD]);
        AHEAD(z + pairs[PAIRS_AHEAD] + 64 / sizeof(T));
        AHEAD(z + pairs[PAIRS_AHEAD + 1]);
        AHEAD(z + pairs[PAIRS_AHEAD + 1] + 64 / sizeof(T));
        UNROLL
        for (k = 0; k < d; k++, a += n, b += n) {
            const V x = *(const V *)b;
            UNROLL
            for (r = 0; r < n; r++) acc[r] += a[r] * x;
            last += b[W] * *(const V *)a;
            corner += a[W] * b[W];
        }
    }
    UNROLL
    for (r = 0; r < n; r++) {
        *(V *)out = acc[r];
        for (c = 0; c < W; c++) block[r * n + c] -= out[c];
    }
    *(V *)out = last;
    for (r = 0; r < W; r++) block[r * n + W] -= out[r];
    block[n * n - 1] -= corner;
}

/* Rows that fit the registers together with their operands. */
#define ROWS(vectors) ((REGISTERS - 4) / (vectors) < 16 ? (REGISTERS - 4) / (vectors) : 16)

/* block -= sum of Za' Zb with all sizes known to the compiler */
INLINE void F(gram_fixed)(const int d, const int h, const int w, ptrdiff_t count,
                                 const int *pairs, const T *z, T *block) {
    int c0, r0;
#if VB
    if (h == W + 1 && w == W + 1 && h <= ROWS(1)) {
        F(gram_odd)(d, count, pairs, z, block);
        return;
    }
#endif
    for (c0 = 0; c0 < w; c0 += 2 * W) {
        if (w - c0 <= W) {
            UNROLL
            for (r0 = 0; r0 < h; r0 += ROWS(1))
                F(gram_rows)(d, h, w, r0, h - r0 < ROWS(1) ? h - r0 : ROWS(1), c0, 1, w - c0,
                             count, pairs, z, block);
        } else {
            UNROLL
            for (r0 = 0; r0 < h; r0 += ROWS(2))
                F(gram_rows)(d, h, w, r0, h - r0 < ROWS(2) ? h - r0 : ROWS(2), c0, 2,
                             w - c0 < 2 * W ? w - c0 : 2 * W, count, pairs, z, block);
        }
    }
}

/* The same for any sizes, by tiles of up to four rows and two vectors. */
static void F(gram_any)(int d, int h, int w, ptrdiff_t count, const int *pairs, const T *z,
                        T *block) {
    int r, c, columns;
    for (c = 0; c < w; c += 2 * W) {
        columns = w - c < 2 * W ? w - c : 2 * W;
#define TILE(rows)                                                                           \
        if (columns <= W)                                                                    \
            F(gram_rows)(d, h, w, r, rows, c, 1, columns, count, pairs, z, block);           \
        else                                                                                 \
            F(gram_rows)(d, h, w, r, rows, c, 2, columns, count, pairs, z, block);
        for (r = 0; r + 4 <= h; r += 4) { TILE(4) }
        for (; r < h; r++) { TILE(1) }
#undef TILE
    }
}

/* block -= sum of Za' Zb over `count` pairs of places in z; block h x w, row-major. */
static void F(gram)(int d, int h, int w, ptrdiff_t count, const int *pairs, const T *z, T *block) {
#define SIZES(d, h, w) ((d) * 10000 + (h) * 100 + (w))
#define CASE(D, H, C) case SIZES(D, H, C): F(gram_fixed)(D, H, C, count, pairs, z, block); return;
    if (h < 100 && w < 100 && d < 100) switch (SIZES(d, h, w)) {
        CASE(1, 3, 3)
        CASE(1, 6, 6)
        CASE(2, 2, 2)
        CASE(2, 3, 3)
        CASE(2, 6, 6)
        CASE(3, 3, 3)
        CASE(3, 6, 6)
        CASE(3, 9, 9)
        CASE(6, 6, 6)
    }
#undef CASE
#undef SIZES
    F(gram_any)(d, h, w, count, pairs, z, block);
}

/* Entities are not in the order of their scalars, which are prefetched. */
#define SCALARS_AHEAD(v) AHEAD(v + (e + PAIRS_AHEAD < count ? at[PAIRS_AHEAD].scalar : 0))

/* y -= Z' t for one entity, y padded over the kept entities */
INLINE void F(spread)(const int d, const Coupling *first, const Coupling *last, const T *z,
                             const T *t, T *y) {
    const Coupling *o;
    for (o = first; o < last; o++) {
        const T *from = z + o->place;
        T *to = y + o->padded;
        const int s = o->width;
        int c, k;
        for (c = 0; c < s; c += W) {
            V sum = *(const V *)(to + c);
            for (k = 0; k < d; k++) sum -= t[k] * *(const V *)(from + k * s + c);
            *(V *)(to + c) = sum;
        }
    }
}

/* t -= Z x for one entity, x padded over the kept entities with zeros */
INLINE void F(collect)(const int d, const Coupling *first, const Coupling *last, const T *z,
                              const T *x, T *t) {
    const Coupling *o;
    int c, i, k;
    for (k = 0; k < d; k += 3) {
        const int rows = d - k < 3 ? d - k : 3;
        V acc[3] = {(V){0}, (V){0}, (V){0}};
        T lanes[W];
        for (o = first; o < last; o++) {
            const int s = o->width;
            const T *from = z + o->place + k * s, *at = x + o->padded;
            for (c = 0; c < s; c += W) {
                const V v = *(const V *)(at + c);
                for (i = 0; i < rows; i++) acc[i] += v * *(const V *)(from + i * s + c);
            }
        }
        for (i = 0; i < rows; i++) {
            T sum = 0;
            *(V *)lanes = acc[i];
            for (c = 0; c < W; c++) sum += lanes[c];
            t[k + i] -= sum;
        }
    }
}

/* t = L^-1 b of the eliminated, and y -= Z' t */
static void F(descend)(ptrdiff_t count, const Entity *entities, const Coupling *couplings,
                       const T *factors, const T *z, const T *b, T *t, T *y) {
    ptrdiff_t e;
    int i, k;
    for (e = 0; e < count; e++) {
        const Entity *at = entities + e;
        const Coupling *first = couplings + at->couplings, *last = couplings + at[1].couplings;
        const T *l = factors + at->factor, *own = b + at->scalar;
        T *to = t + at->scalar;
        const int d = at->size;
        SCALARS_AHEAD(b);
        SCALARS_AHEAD(t);
        for (i = 0; i < d; i++) {
            T s = own[i];
            for (k = 0; k < i; k++) s -= l[i * d + k] * to[k];
            to[i] = s * l[i * d + i];
        }
        if (d == 3) F(spread)(3, first, last, z, to, y);
        else F(spread)(d, first, last, z, to, y);
    }
}

/* b = L^-T (t - Z x) of the eliminated; t is overwritten */
static void F(ascend)(ptrdiff_t count, const Entity *entities, const Coupling *couplings,
                      const T *factors, const T *z, const T *x, T *t, T *b) {
    ptrdiff_t e;
    int i, k;
    for (e = 0; e < count; e++) {
        const Entity *at = entities + e;
        const Coupling *first = couplings + at->couplings, *last = couplings + at[1].couplings;
        const T *l = factors + at->factor;
        T *from = t + at->scalar, *to = b + at->scalar;
        const int d = at->size;
        SCALARS_AHEAD(b);
        SCALARS_AHEAD(t);
        if (d == 3) F(collect)(3, first, last, z, x, from);
        else F(collect)(d, first, last, z, x, from);
        for (i = d - 1; i >= 0; i--) {
            T s = from[i];
            for (k = i + 1; k < d; k++) s -= l[k * d + i] * to[k];
            to[i] = s * l[i * d + i];
        }
    }
}

/* y -= Z' Z x; t holds one entity */
static void F(apply)(ptrdiff_t count, const Entity *entities, const Coupling *couplings,
                     const T *z, const T *x, T *t, T *y) {
    ptrdiff_t e;
    int i;
    for (e = 0; e < count; e++) {
        const Entity *at = entities + e;
        const Coupling *first = couplings + at->couplings, *last = couplings + at[1].couplings;
        const int d = at->size;
        for (i = 0; i < d; i++) t[i] = 0;
        if (d == 3) F(collect)(3, first, last, z, x, t);
        else F(collect)(d, first, last, z, x, t);
        for (i = 0; i < d; i++) t[i] = -t[i];
        if (d == 3) F(spread)(3, first, last, z, t, y);
        else F(spread)(d, first, last, z, t, y);
    }
}

/* y += B x for a symmetric matrix of blocks of which the lower triangle is stored, with full
   diagonal blocks. Vectors are padded, inputs with zeros. */
static void F(symmetric)(ptrdiff_t count, const Block *blocks, const T *values, const T *x, T *y) {
    const Block *at;
    T lanes[W];
    int c, r;
    for (at = blocks; at < blocks + count; at++) {
        const T *b = values + at->place, *xi = x + at->row, *xj = x + at->column;
        T *yi = y + at->row, *yj = y + at->column;
        const int w = at->width, h = at->height;
        for (c = 0; c < w; c += W) {
            const T *row = b + c;
            V sum = *(const V *)(yj + c);
            const V v = *(const V *)(xj + c);
            if (at->row == at->column) {
                for (r = 0; r < h; r++, row += w) sum += xi[r] * *(const V *)row;
            } else {
                for (r = 0; r < h; r++, row += w) {
                    const V part = *(const V *)row;
                    T s = 0;
                    int i;
                    sum += xi[r] * part;
                    *(V *)lanes = part * v;
                    for (i = 0; i < W; i++) s += lanes[i];
                    yi[r] += s;
                }
            }
            *(V *)(yj + c) = sum;
        }
    }
}

#undef SCALARS_AHEAD
#undef ROWS
#undef PIECES
#undef HALF_PIECE
#undef QUARTER_PIECE
#undef V
#undef W
