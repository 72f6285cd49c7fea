"""The C functions that add or store columns of W lanes as rows, one per lane."""

from __future__ import annotations

from arael.compiler.emit.writer import Writer

# Tiles of 4 x 4 doubles or 8 x 8 floats in 256-bit registers: as fast as wider ones, and there on
# every processor with AVX. Each step swaps between rows 1, 2 and (of floats) 4 apart.
_SHUFFLES = {
    "double": (
        4,
        [
            (1, "0, 4, 2, 6", "1, 5, 3, 7"),
            (2, "0, 1, 4, 5", "2, 3, 6, 7"),
        ],
    ),
    "float": (
        8,
        [
            (1, "0, 8, 2, 10, 4, 12, 6, 14", "1, 9, 3, 11, 5, 13, 7, 15"),
            (2, "0, 1, 8, 9, 4, 5, 12, 13", "2, 3, 10, 11, 6, 7, 14, 15"),
            (4, "0, 1, 2, 3, 8, 9, 10, 11", "4, 5, 6, 7, 12, 13, 14, 15"),
        ],
    ),
}

# Columns that may be read behind the last one.
PADDING = 7

_HEAD = """\
/* Columns of lanes as rows: at[w][k] += q[k][w], or = if not `adds`. Compilers make single scalars
   of the plain loops, through memory; tiles stay in registers. */
#if defined(__AVX__) && (defined(__GNUC__) || defined(__clang__))
#if defined(__clang__)
#define ARAEL_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define ARAEL_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (arael_order){__VA_ARGS__})
#endif
#define ARAEL_UNROLL _Pragma("GCC unroll 8")
typedef SCALAR arael_row __attribute__((vector_size(32)));
typedef SCALAR arael_half __attribute__((vector_size(16)));
typedef INTEGER arael_order __attribute__((vector_size(32)));
static inline __attribute__((always_inline)) void move_rows(
    ptrdiff_t count, const SCALAR *q, SCALAR *const *at, int adds) {
    ptrdiff_t k, w;
    int i;
    for (k = 0; k < count; k += TILE)
        for (w = 0; w < LANES; w += TILE) {
            arael_row a[TILE], b[TILE];
            ARAEL_UNROLL
            for (i = 0; i < TILE; i++)
                memcpy(&a[i], q + (k + i) * LANES + w, sizeof(arael_row));"""

_TAIL = """\
            ARAEL_UNROLL
            for (i = 0; i < TILE; i++) {
                SCALAR *h = at[w + i] + k;
                const arael_row v = SOURCE[i];
                if (k + TILE <= count) {
                    arael_row sum = v;
                    if (adds) {
                        memcpy(&sum, h, sizeof(sum));
                        sum += v;
                    }
                    memcpy(h, &sum, sizeof(sum));
                } else {
                    ptrdiff_t j = 0;
                    if (count - k >= TILE / 2) {
                        const arael_half low = {HALF};
                        arael_half sum = low;
                        if (adds) {
                            memcpy(&sum, h, sizeof(sum));
                            sum += low;
                        }
                        memcpy(h, &sum, sizeof(sum));
                        j = TILE / 2;
                    }
                    for (; j < count - k; j++) h[j] = adds ? h[j] + v[j] : v[j];
                }
            }
        }
}
#else
static void move_rows(ptrdiff_t count, const SCALAR *q, SCALAR *const *at, int adds) {
    ptrdiff_t k, w;
    for (w = 0; w < LANES; w++)
        for (k = 0; k < count; k++)
            at[w][k] = adds ? at[w][k] + q[k * LANES + w] : q[k * LANES + w];
}
#endif
#if defined(_MSC_VER)
#define ARAEL_APART static __declspec(noinline)
#else
#define ARAEL_APART static __attribute__((noinline))
#endif
ARAEL_APART void add_rows(ptrdiff_t count, const SCALAR *q, SCALAR *const *at) {
    move_rows(count, q, at, 1);
}
ARAEL_APART void put_rows(ptrdiff_t count, const SCALAR *q, SCALAR *const *at) {
    move_rows(count, q, at, 0);
}"""


def emit_rows(w: Writer, scalar: str, lanes: int) -> None:
    """Write ``add_rows(count, q, at)``: ``at[w][k] += q[k][w]`` for `count` columns; ``put_rows``.

    The latter stores instead.
    """
    tile, steps = _SHUFFLES[scalar]
    body = [_HEAD]
    source, target = "a", "b"
    for apart, low, high in steps:
        body.append("            ARAEL_UNROLL")
        body.append("            for (i = 0; i < TILE; i++)")
        body.append(f"                if (!(i & {apart})) {{")
        for place, picked in (("i", low), (f"i + {apart}", high)):
            body.append(
                f"                    {target}[{place}] = ARAEL_SHUFFLE("
                f"{source}[i], {source}[i + {apart}], {picked});"
            )
        body.append("                }")
        source, target = target, source
    body.append(_TAIL)
    text = "\n".join(body)
    for name, value in (
        ("SCALAR", scalar),
        ("INTEGER", "long long" if scalar == "double" else "int"),
        ("TILE", str(tile)),
        ("LANES", str(lanes)),
        ("SOURCE", source),
        ("HALF", ", ".join(f"v[{j}]" for j in range(tile // 2))),
    ):
        text = text.replace(name, value)
    w.lines_of(text.split("\n"))
