"""J'r and J'J by loops over a dense Jacobian, for constraints too large to spell out."""

from __future__ import annotations

from arael.compiler.emit.writer import Writer
from arael.compiler.groups import Kernel


def start(tangent: list[int], use: int) -> int:
    """First column of a use in the dense Jacobian."""
    return sum(tangent[:use])


def declare(w: Writer, kernel: Kernel, tangent: list[int]) -> None:
    """Declare the Jacobian and the products."""
    total, r = sum(tangent), kernel.group.residuals
    w.line("cdef Py_ssize_t i, j")
    w.line(f"cdef real jr[{r}][{total}][W]")
    w.line(f"cdef real gr[{total}][W]")
    w.line(f"cdef real hr[{total}][{total}][W]")


def products(w: Writer, kernel: Kernel, tangent: list[int], sources: list[str]) -> None:
    """Form the products of one block of lanes; `sources` are residuals, then Jacobian entries."""
    group = kernel.group
    total, r = sum(tangent), group.residuals
    known = {
        (k, start(tangent, use) + i): sources[r + e] for e, (k, use, i) in enumerate(group.jacobian)
    }
    with w.block("for w in range(W):"):
        for k in range(r):
            for i in range(total):
                w.line(f"jr[{k}][{i}][w] = {known.get((k, i), '0')}")
    with w.block(f"for i in range({total}):"):
        with w.block("for w in range(W):"):
            w.line("gr[i][w] = 0")
        with w.block("for j in range(i + 1):"), w.block("for w in range(W):"):
            w.line("hr[i][j][w] = 0")
    for k in range(r):
        with w.block(f"for i in range({total}):"):
            with w.block("for w in range(W):"):
                w.line(f"gr[i][w] += jr[{k}][i][w] * {sources[k]}")
            with w.block("for j in range(i + 1):"), w.block("for w in range(W):"):
                w.line(f"hr[i][j][w] += jr[{k}][i][w] * jr[{k}][j][w]")


def columns(
    tangent: list[int],
) -> tuple[dict[tuple[int, int], str], dict[tuple[int, int, int, int], str]]:
    """Where the products are: J'r by (use, tangent), J'J by (use a, use b, row, column)."""
    uses = range(len(tangent))
    gradient = {(u, i): f"gr[{start(tangent, u) + i}][w]" for u in uses for i in range(tangent[u])}
    found = {
        (a, b, i, j): f"hr[{start(tangent, a) + i}][{start(tangent, b) + j}][w]"
        for a in uses
        for b in range(a + 1)
        for i in range(tangent[a])
        for j in range(tangent[b] if a != b else i + 1)
    }
    return gradient, found
