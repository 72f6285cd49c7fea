"""What compiled passes find of a pattern and lay out, against definitions written with NumPy."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.runtime.linear.analysis import analyse
from arael.runtime.linear.bandwidth import half_bandwidth
from arael.runtime.linear.planning import (
    adjacency,
    independent_set,
    minimum_degree,
    plan_fronts,
    time_of_front,
)
from tests.runtime.linear.block_matrices import BlockPattern, build
from tests.runtime.linear.test_orderings import patterns


def leading(rows: int, pad: int) -> int:
    """Whole cache lines, an odd number of them if they are more than 16."""
    lines = -(-rows // pad)
    return (lines + (lines > 16 and lines % 2 == 0)) * pad


def coupled(pattern: BlockPattern) -> np.ndarray:
    """(nb, nb) whether two different blocks are coupled."""
    nb = pattern.block_count
    found = np.zeros((nb, nb), dtype=bool)
    columns = np.repeat(np.arange(nb), np.diff(pattern.column_start))
    found[columns, pattern.rows] = found[pattern.rows, columns] = True
    np.fill_diagonal(found, val=False)
    return found


@st.composite
def bundles(draw: st.DrawFn) -> BlockPattern:
    """Draw a few entities that many of another size are coupled with, some of which are empty."""
    few, many = draw(st.integers(1, 8)), draw(st.integers(1, 40))
    sizes = [6] * few + draw(st.lists(st.sampled_from([0, 3, 3, 3]), min_size=many, max_size=many))
    pairs = draw(
        st.lists(st.tuples(st.integers(0, few - 1), st.integers(0, few + many - 1)), max_size=120)
    )
    return build(sizes, pairs)


def independent(pattern: BlockPattern) -> np.ndarray:
    """The rule of `independent_set` in NumPy."""
    beside, sizes = coupled(pattern), pattern.sizes
    degree, nb = beside.sum(axis=1), pattern.block_count
    usable = (sizes > 0) & (degree <= max(64, 10 * degree.sum() / nb))
    for size in np.unique(sizes[sizes > 0]):
        kind = usable & (sizes == size)
        half = 2 * np.count_nonzero(sizes == size) >= nb and 2 * kind.sum() >= nb
        if half and not beside[np.ix_(kind, kind)].any():
            return kind
    taken = np.zeros(nb, dtype=bool)
    for v in np.argsort(beside @ sizes, kind="stable"):
        taken[v] = usable[v] and not (beside[v] & taken).any()
    return taken


@settings(max_examples=100, deadline=None)
@given(pattern=st.one_of(patterns(), bundles()))
def test_what_is_eliminated_first_follows_the_rule(pattern: BlockPattern) -> None:
    found = independent_set(pattern)
    np.testing.assert_array_equal(found, independent(pattern))
    assert not coupled(pattern)[np.ix_(found, found)].any()


@settings(max_examples=100, deadline=None)
@given(pattern=st.one_of(patterns(), bundles()))
def test_half_bandwidth_is_that_of_the_matrix(pattern: BlockPattern) -> None:
    scalars = np.repeat(np.arange(pattern.block_count), pattern.sizes)
    full = (coupled(pattern) | np.eye(pattern.block_count, dtype=bool))[np.ix_(scalars, scalars)]
    row, column = np.nonzero(full)
    widest = int((row - column).max(initial=0))
    # An empty block has a place, too: the declared width then need not be reached by a scalar.
    assert half_bandwidth(pattern) == widest or (pattern.sizes == 0).any()
    assert half_bandwidth(pattern) >= widest


@settings(max_examples=100, deadline=None)
@given(pattern=patterns(), staying=st.integers(0, 60))
def test_what_stays_is_not_ordered(pattern: BlockPattern, staying: int) -> None:
    start, neighbours = adjacency(pattern)
    staying = min(staying, pattern.block_count)
    order = minimum_degree(start, neighbours, pattern.sizes, staying)
    assert sorted(order) == list(range(pattern.block_count - staying))


@settings(max_examples=100, deadline=None)
@given(pattern=patterns())
def test_fronts_lie_side_by_side(pattern: BlockPattern) -> None:
    """Sizes are those of their blocks, and no triangle or panel reaches into another."""
    pad = 8
    nodes = analyse(pattern, "minimum_degree").supernodes
    fronts = plan_fronts(nodes, pattern.sizes, pad, 100)
    width = pattern.sizes[nodes.order]
    ns = len(nodes.parent)
    end = 0
    for s in range(ns):
        mine = slice(nodes.start[s], nodes.start[s + 1])
        rows = nodes.rows[nodes.row_start[s] : nodes.row_start[s + 1]]
        k, r = int(width[mine].sum()), int(width[rows].sum())
        assert (fronts.columns[s], fronts.below[s]) == (k, r)
        assert fronts.first[s] == width[: nodes.start[s]].sum()
        assert (fronts.tall[s], fronts.low[s]) == (leading(k, pad), leading(r + 1, pad))
        assert fronts.triangle[s] >= end
        assert fronts.panel[s] >= fronts.triangle[s] + k * fronts.tall[s] + pad
        end = fronts.panel[s] + k * fronts.low[s] + pad
        children = fronts.children[fronts.child_start[s] : fronts.child_start[s + 1]]
        assert children.tolist() == np.flatnonzero(nodes.parent == s).tolist()
    assert fronts.storage == end
    assert time_of_front(fronts.columns, fronts.below).shape == (ns,)
