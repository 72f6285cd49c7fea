"""J'r and J'J by loops over a stored Jacobian, for constraints too large to spell out.

The Jacobian is stored as it is known to be filled: residual after residual, the columns that are
not zero. What is zero takes no part in the products.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.compiler.emit.writer import Writer
from arael.compiler.groups import Kernel


def _column(tangent: Sequence[int], use: int, i: int) -> int:
    return sum(tangent[:use]) + i


def _entries(kernel: Kernel) -> list[int]:
    """Numbers of the Jacobian entries, by residual."""
    jacobian = kernel.group.jacobian
    return sorted(range(len(jacobian)), key=lambda e: jacobian[e])


def emit_tables(w: Writer, number: int, kernel: Kernel, tangent: Sequence[int]) -> None:
    """Write the column of each stored entry, and where each residual's entries end."""
    group = kernel.group
    order = _entries(kernel)
    columns = [_column(tangent, *group.jacobian[e][1:]) for e in order]
    ends = [sum(group.jacobian[e][0] < k for e in order) for k in range(group.residuals + 1)]
    with w.block("cdef extern from *:"):
        w.line('"""')
        for name, values in (("columns", columns), ("ends", ends)):
            w.line(f"static const int {name}_{number}[] = {{{', '.join(map(str, values))}}};")
        w.line('"""')
        w.line(f"const int columns_{number}[]")
        w.line(f"const int ends_{number}[]")
    w.line()


def declare(w: Writer, kernel: Kernel, tangent: Sequence[int]) -> None:
    """Declare the Jacobian and the products."""
    total, r = sum(tangent), kernel.group.residuals
    w.line("cdef Py_ssize_t i, j, k")
    w.line(f"cdef real rr[{r}][W]")
    w.line(f"cdef real jr[{len(kernel.group.jacobian)}][W]")
    w.line(f"cdef real gr[{total}][W]")
    w.line(f"cdef real hr[{total}][{total}][W]")


def products(w: Writer, number: int, kernel: Kernel, sources: Sequence[str]) -> None:
    """Form the products of one block of lanes; `sources` are residuals, then Jacobian entries."""
    r = kernel.group.residuals
    with w.block("for w in range(W):"):
        for k in range(r):
            w.line(f"rr[{k}][w] = {sources[k]}")
        for place, e in enumerate(_entries(kernel)):
            w.line(f"jr[{place}][w] = {sources[r + e]}")
    w.line("memset(gr, 0, sizeof(gr))")
    w.line("memset(hr, 0, sizeof(hr))")
    begin, end = f"ends_{number}[k]", f"ends_{number}[k + 1]"
    row, column = f"columns_{number}[i]", f"columns_{number}[j]"
    with w.block(f"for k in range({r}):"), w.block(f"for i in range({begin}, {end}):"):
        with w.block("for w in range(W):"):
            w.line(f"gr[{row}][w] += jr[i][w] * rr[k][w]")
        with w.block(f"for j in range({begin}, i + 1):"), w.block("for w in range(W):"):
            w.line(f"hr[{row}][{column}][w] += jr[i][w] * jr[j][w]")


def places(
    kernel: Kernel, tangent: Sequence[int]
) -> tuple[dict[tuple[int, int], str], dict[tuple[int, int, int, int], str]]:
    """Where the products are: J'r by (use, tangent), J'J by (use a, use b, row, column)."""
    gradient = {(u, i): f"gr[{_column(tangent, u, i)}][w]" for u, i in kernel.gradient}
    found = {
        (a, b, i, j): f"hr[{_column(tangent, a, i)}][{_column(tangent, b, j)}][w]"
        for a, b, i, j in kernel.products
    }
    return gradient, found
