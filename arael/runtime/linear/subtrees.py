"""Splits the tree of a multifrontal factorisation into bundles of subtrees and a top.

Subtrees are independent, so threads factor them in parallel; the fronts above come after them and
are wide enough for parallelism within a front. The split follows from the tree and not from the
number of threads. After A. Geist and E. Ng, "Task scheduling for parallel sparse Cholesky
factorization", Int. J. Parallel Programming 18 (1989): the most expensive subtree is split until
all are below the limit.
"""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

#: A subtree with more than this fraction of the total cost is split.
FRACTION = 1 / 8

#: Minimum predicted nanoseconds of a bundle.
GRAIN = 500_000.0

#: Bundles are filled up to this fraction of the total.
BUNDLE = 1 / 16


def worth_bundling(count: int, total: float) -> bool:
    """Whether so many fronts of so much cost in all can make two bundles."""
    return total >= 2 * GRAIN and count >= 3


def bundle_subtrees(parent: Ints, cost: Floats, alone: NDArray[np.bool_]) -> tuple[Ints, int]:
    """Bundle of each front, -1 for the top, and the number of bundles, the most expensive first.

    Parameters
    ----------
    parent : (ns,) int64
        Parents come after their children; -1 for roots.
    cost : (ns,) float
        Predicted nanoseconds of each front.
    alone : (ns,) bool
        Fronts that must not be in a bundle.
    """
    total = float(cost.sum())
    none = np.full(len(parent), -1, dtype=np.int64), 0
    if not worth_bundling(len(parent), total):
        return none
    roots = _open(parent, np.where(alone, np.inf, cost), FRACTION * total)
    limit = max(BUNDLE * total, GRAIN)
    number, bundle, filled = {}, 0, 0.0
    for root, price in sorted(roots):
        if filled and filled + price > limit:
            bundle, filled = bundle + 1, 0.0
        number[root] = bundle
        filled += price
    found = np.full(len(parent), -1, dtype=np.int64)
    for s in range(len(parent) - 1, -1, -1):
        found[s] = number[s] if s in number else (found[parent[s]] if parent[s] >= 0 else -1)
    inside = found >= 0
    if bundle == 0 or float(cost[inside].sum()) < 2 * GRAIN:
        return none
    prices = np.bincount(found[inside], weights=cost[inside], minlength=bundle + 1)
    rank = np.empty(bundle + 1, dtype=np.int64)
    rank[np.argsort(-prices, kind="stable")] = np.arange(bundle + 1)
    found[inside] = rank[found[inside]]
    return found, bundle + 1


def _open(parent: Ints, cost: Floats, limit: float) -> list[tuple[int, float]]:
    """Roots and costs of disjoint subtrees, each of cost at most `limit`."""
    above, whole = parent.tolist(), cost.tolist()
    children: list[list[int]] = [[] for _ in above]
    for s, p in enumerate(above):
        if p >= 0:
            whole[p] += whole[s]
            children[p].append(s)
    heap = [(-whole[s], s) for s, p in enumerate(above) if p < 0]
    heapq.heapify(heap)
    closed: list[tuple[int, float]] = []
    while heap and -heap[0][0] > limit:
        _, s = heapq.heappop(heap)
        if not children[s]:
            continue  # a front above the limit by itself belongs to the top
        for c in children[s]:
            heapq.heappush(heap, (-whole[c], c))
    closed += [(s, -price) for price, s in heap]
    return closed
