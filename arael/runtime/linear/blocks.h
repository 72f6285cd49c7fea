/* Copying row-major blocks to column-major places. Included once for each scalar T, with names by F.
 *
 * Blocks are small and of few sizes: those of planes, planar and spatial poses and cameras, and of
 * landmarks with these, are copied by unrolled loops. The blocks of a front are scattered in
 * memory, so they are prefetched AHEAD of use.
 */

/* Rows become rows. */
COPY_INLINE void F(turn)(const T *from, T *to, ptrdiff_t ld, int h, int w) {
    int i, j;
    COPY_UNROLL
    for (j = 0; j < w; j++)
        COPY_UNROLL
        for (i = 0; i < h; i++) to[i + j * ld] = from[i * w + j];
}

/* Rows become columns. */
COPY_INLINE void F(keep)(const T *from, T *to, ptrdiff_t ld, int h, int w) {
    int i;
    COPY_UNROLL
    for (i = 0; i < h; i++) memcpy(to + i * ld, from + i * w, w * sizeof(T));
}

/* Below the diagonal, rows become rows. */
COPY_INLINE void F(below)(const T *from, T *to, ptrdiff_t ld, int h, int w) {
    int i, j;
    COPY_UNROLL
    for (i = 1; i < h; i++)
        COPY_UNROLL
        for (j = 0; j < i; j++) to[i + j * ld] = from[i * w + j];
}

/* Any size. */
static void F(copy_any)(const T *from, T *to, ptrdiff_t ld, ptrdiff_t h, ptrdiff_t w, int how) {
    ptrdiff_t i, j;
    for (i = 0; i < h; i++)
        for (j = 0; j < (how == 2 ? i : w); j++)
            to[how == 1 ? j + i * ld : i + j * ld] = from[i * w + j];
}

/* Copy the blocks of the table (first value, place, leading dimension, size) from begin to end. */
static void F(copy_blocks)(const long long *blocks, ptrdiff_t begin, ptrdiff_t end, const T *values,
                           T *storage) {
#define SIZE(how, h, w) ((long long)(how) << 2 * HALF | (long long)(h) << HALF | (w))
#define SIZED(h, w)                                         \
    case SIZE(0, h, w): F(turn)(from, to, ld, h, w); break; \
    case SIZE(1, h, w): F(keep)(from, to, ld, h, w); break;
#define DIAGONAL(h) \
    case SIZE(2, h, h): F(below)(from, to, ld, h, h); break;
    const long long mask = (1LL << HALF) - 1, *b;
    for (b = blocks + 4 * begin; b < blocks + 4 * end; b += 4) {
        const T *from = values + b[0];
        T *to = storage + b[1];
        const ptrdiff_t ld = b[2];
        if (blocks + 4 * end - b > 4 * AHEAD) {
            const T *soon = values + b[4 * AHEAD];
            COPY_SOON(soon);
            COPY_SOON(soon + 64 / sizeof(T));
            COPY_SOON(soon + 128 / sizeof(T));
        }
        switch (b[3]) {
        SIZED(3, 3) SIZED(3, 6) SIZED(6, 3) SIZED(6, 6) SIZED(3, 9) SIZED(9, 3) SIZED(9, 9)
        DIAGONAL(3) DIAGONAL(6) DIAGONAL(9)
        default:
            F(copy_any)(from, to, ld, b[3] >> HALF & mask, b[3] & mask, b[3] >> 2 * HALF);
        }
    }
#undef SIZE
#undef SIZED
#undef DIAGONAL
}
