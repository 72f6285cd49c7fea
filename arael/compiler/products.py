"""The products J'J and J'r of one constraint, and the blocks that they go into."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from arael.check.typed import ConstraintSite
from arael.compiler.entities import StateModel
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Use
from arael.symbolic.graph import Graph

# Beyond these the products are loops over the Jacobian.
UNROLLED_PRODUCTS = 1500  # multiplications in J'J
UNROLLED_TARGETS = 150  # entries of J'J

# Multiplications in J'J of one instance beyond which a constraint is refused: one residual of some
# 3000 parameters, whose block of the Hessian takes 40 MB.
MAX_PRODUCTS = 5_000_000


def products_of(
    g: Graph, residuals: list[int], entries: dict[tuple[int, int, int], int]
) -> tuple[dict[tuple[int, int], int], dict[tuple[int, int, int, int], int]]:
    """J'r by (use, tangent) and the lower half of J'J by (use a, use b, row, column)."""
    columns: dict[tuple[int, int], dict[int, int]] = {}
    for (k, use, tangent), node in sorted(entries.items()):
        columns.setdefault((use, tangent), {})[k] = node
    keys = sorted(columns)
    gradient = {c: _sum(g, [(n, residuals[k]) for k, n in columns[c].items()]) for c in keys}
    products = {}
    for p, (a, i) in enumerate(keys):
        for b, j in keys[: p + 1]:
            left, right = columns[a, i], columns[b, j]
            common = [(left[k], right[k]) for k in left if k in right]
            if common:
                products[a, b, i, j] = _sum(g, common)
    return gradient, products


def many_products(entries: Iterable[tuple[int, int, int]], site: ConstraintSite) -> bool:
    """Whether J'J takes more than is spelled out, by the places of the Jacobian's entries.

    Raises
    ------
    AraelError
        E0620: it takes more than `MAX_PRODUCTS`.
    """
    rows: dict[int, list[tuple[int, int]]] = {}
    for residual, use, tangent in entries:
        rows.setdefault(residual, []).append((use, tangent))
    multiplications = sum(len(row) * (len(row) + 1) // 2 for row in rows.values())
    if multiplications > MAX_PRODUCTS:
        raise AraelError(
            Diagnostic(
                "E0620",
                f"J'J of `{site.label}` takes {multiplications} multiplications for each instance, "
                f"more than {MAX_PRODUCTS}",
                site.span,
                help=("split the residual into constraints of fewer parameters each",),
            )
        )
    if multiplications > UNROLLED_PRODUCTS:
        return True
    targets = {(a, b) for row in rows.values() for i, a in enumerate(row) for b in row[: i + 1]}
    return len(targets) > UNROLLED_TARGETS


def _sum(g: Graph, pairs: list[tuple[int, int]]) -> int:
    total = g.op("mul", *pairs[0])
    for left, right in pairs[1:]:
        total = g.op("add", total, g.op("mul", left, right))
    return total


def triplet_pairs(
    site: ConstraintSite, states: Sequence[StateModel], uses: Sequence[Use]
) -> tuple[tuple[int, int], ...]:
    """Pairs of uses that go into `triplets`: those without a separate block."""
    if not site.triplets:
        return ()
    apart = set(crossed_pairs(site, states, uses))
    return tuple((a, b) for b in range(len(uses)) for a in range(b) if (a, b) not in apart)


def crossed_pairs(
    site: ConstraintSite, states: Sequence[StateModel], uses: Sequence[Use]
) -> tuple[tuple[int, int], ...]:
    """Pairs of uses, ascending, that have a separate named block."""
    keys = [(site.slots[u.slot].steps, states[u.entity].entity.prefix) for u in uses]
    return tuple(
        (a, b)
        for b in range(len(uses))
        for a in range(b)
        if frozenset((keys[a], keys[b])) in site.crossed
    )
