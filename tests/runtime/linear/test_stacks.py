"""Where update matrices wait: none is overwritten before its parent has taken it."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.linear.planning import Stacks, place_updates
from arael.runtime.linear.subtrees import bundle_subtrees

Ints = np.ndarray


def random_tree(rng: np.random.Generator, count: int) -> Ints:
    """Parents in a postorder: children of a front stand right before it."""
    parent = np.full(count, -1, dtype=np.int64)
    roots: list[int] = []
    for s in range(count):
        for _ in range(min(len(roots), int(rng.integers(0, 4)))):
            parent[roots.pop()] = s
        roots.append(s)
    return parent


def check(stacks: Stacks, parent: Ints, size: Ints, group: Ints) -> None:
    """Process the sequence, and check at each write that no pending update is overwritten."""
    waiting: set[int] = set()
    seen = np.zeros(len(parent), dtype=bool)
    for s in stacks.sequence.tolist():
        children = np.flatnonzero(parent == s)
        assert seen[children].all()
        seen[s] = True
        begin, end = stacks.update[s], stacks.update[s] + size[s]
        assert 0 <= begin <= end <= (stacks.shared_extent if stacks.shared[s] else stacks.extent)
        for other in waiting:
            if stacks.shared[s] != stacks.shared[other]:
                continue
            # After a bundle, the workspace of its thread is empty.
            assert stacks.shared[s] or group[s] == group[other]
            first, last = stacks.update[other], stacks.update[other] + size[other]
            assert end <= first or last <= begin
        if parent[s] >= 0:
            waiting.add(s)
        waiting -= set(children.tolist())
    assert seen.all()
    assert not waiting


@pytest.mark.parametrize("seed", range(20))
def test_nothing_is_overwritten(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 120))
    parent, size = random_tree(rng, count), rng.integers(1, 500, count)
    size = np.where(parent >= 0, size, 0)
    whole = np.full(count, -1, dtype=np.int64)
    alone = place_updates(parent, size, whole, 0, 8)
    assert alone.sequence.tolist() == list(range(count))
    assert not alone.shared.any()
    check(alone, parent, size, whole)
    costs = rng.uniform(1e5, 2e6, count)
    bundle, bundles = bundle_subtrees(parent, costs, np.zeros(count, dtype=bool))
    together = place_updates(parent, size, bundle, bundles, 8)
    assert len(together.ends) == bundles + 2
    for b in range(bundles):
        assert (bundle[together.sequence[together.ends[b] : together.ends[b + 1]]] == b).all()
    check(together, parent, size, bundle)


def test_one_thread_needs_less() -> None:
    """A chain of equal bundles: their roots wait only where several threads make them."""
    parent = np.array([1, 8, 3, 8, 5, 8, 7, 8, -1], dtype=np.int64)
    size = np.array([100, 10, 100, 10, 100, 10, 100, 10, 0])
    bundle = np.array([0, 0, 1, 1, 2, 2, 3, 3, -1], dtype=np.int64)
    alone = place_updates(parent, size, np.full(9, -1, dtype=np.int64), 0, 8)
    together = place_updates(parent, size, bundle, 4, 8)
    assert (alone.extent, alone.shared_extent) == (104 + 40, 0)
    assert (together.extent, together.shared_extent) == (104, 40)
