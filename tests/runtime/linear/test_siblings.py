"""Merged siblings: the result is a valid symbolic factor of lower cost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from arael.runtime.linear.analysis import ORDERINGS, analyse
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.planning import (
    Supernodes,
    adjacency,
    find_supernodes,
    join_siblings,
    time_of_front,
)
from tests.runtime.linear.block_matrices import BlockPattern, build, dense, positive, slam
from tests.runtime.linear.test_orderings import patterns


def members(nodes: Supernodes, s: int) -> tuple[set[int], set[int]]:
    """Columns and rows below them of one supernode."""
    rows = nodes.rows[nodes.row_start[s] : nodes.row_start[s + 1]]
    return set(range(nodes.start[s], nodes.start[s + 1])), set(rows.tolist())


def check(pattern: BlockPattern, nodes: Supernodes) -> None:
    """Every coupling has a place, and the rows below a front are rows of its parent."""
    assert np.array_equal(np.sort(nodes.order), np.arange(pattern.block_count))
    position = np.argsort(nodes.order)
    sets = [members(nodes, s) for s in range(len(nodes.parent))]
    owner = np.repeat(np.arange(len(sets)), np.diff(nodes.start))
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    for a, b in zip(position[pattern.rows], position[columns], strict=True):
        own, below = sets[owner[min(a, b)]]
        assert max(a, b) in own or max(a, b) in below
    for s, parent in enumerate(nodes.parent):
        assert not sets[s][1] if parent < 0 else s < parent
        if parent >= 0:
            assert sets[s][1] <= sets[parent][0] | sets[parent][1]


@pytest.mark.parametrize("name", sorted(ORDERINGS))
@settings(max_examples=60, deadline=None)
@given(pattern=patterns())
def test_still_a_symbolic_factor(name: str, pattern: BlockPattern) -> None:
    start, neighbours = adjacency(pattern)
    order = ORDERINGS[name](start, neighbours, pattern.sizes)
    check(pattern, find_supernodes(start, neighbours, pattern.sizes, order))


def test_landmarks_seen_from_the_same_poses_are_one_front() -> None:
    poses, landmarks = 20, 40
    pairs = [(j, poses + i) for i in range(landmarks) for j in range(poses)]
    pattern = build([6] * poses + [3] * landmarks, pairs)
    nodes = analyse(pattern, "minimum_degree").supernodes
    assert len(nodes.parent) < 5
    check(pattern, nodes)
    values, diagonal = positive(pattern, 3)
    solver = make_solver("sparse", pattern, ordering="minimum_degree")
    assert solver.factorise(values, diagonal) == 0
    b = np.ones(pattern.size)
    assert np.abs(dense(pattern, values, diagonal) @ solver.solved(b) - b).max() < 1e-12


def test_only_brothers_with_rows_in_common_join() -> None:
    # Four leaves of one root: two with the same ten rows, two with others, far from each other.
    size, rows = 3, 10
    start = np.array([0, 1, 2, 3, 4, 4 + 3 * rows])
    parent = np.array([4, 4, 4, 4, -1])
    first = [4, 4, 4 + rows, 4 + 2 * rows]
    lists = [np.arange(f, f + rows) for f in first]
    row_start = np.array([0, 10, 20, 30, 40, 40])
    weights = np.full(4 + 3 * rows, 6)
    weights[:4] = size
    into = join_siblings(start, parent, row_start, np.concatenate(lists), weights)
    assert into.tolist() == [1, 1, 2, 3, 4]


def test_joining_is_predicted_to_pay() -> None:
    """The whole costs less than landmarks on their own would."""
    pattern = slam(60, 300)
    nodes = analyse(pattern, "minimum_degree").supernodes
    width = pattern.sizes[nodes.order]
    before = np.concatenate(([0], np.cumsum(width)))
    below = np.concatenate(([0], np.cumsum(width[nodes.rows])))
    k, r = np.diff(before[nodes.start]), np.diff(below[nodes.row_start])
    joined = (k > 3) & (np.bincount(nodes.parent[nodes.parent >= 0], minlength=len(k)) == 0)
    assert joined.any()
    alone = (k[joined] / 3 * time_of_front(3, r[joined] / 2)).sum()
    assert time_of_front(k[joined], r[joined]).sum() < alone
