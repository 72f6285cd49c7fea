"""Parts are separated by the boundary, and each instance is of exactly one part."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arael.distributed.parts.data import Columns, whole_skeleton
from arael.distributed.parts.graph import Graph, graph_of
from arael.distributed.parts.shares import lenient, shares_of, skeleton
from arael.distributed.parts.split import BOUNDARY, by_labels, by_separators, part_of_instances
from arael.runtime.system import build_system, free_scalars

from .problems import PROBLEMS, arrays_of


def whole(model: Any) -> tuple[Any, Any, Any, Graph]:
    layout = model._compiled.layout
    store = whole_skeleton(lenient(layout), skeleton(layout), Columns([arrays_of(model)], "data"))
    system = build_system(store, [free_scalars(store, e, frozenset()) for e in layout.entities])
    return layout, store, system, graph_of(store, layout.groups, system)


def assert_separated(graph: Graph, parts: Any) -> None:
    owner = np.repeat(np.arange(graph.size), np.diff(graph.start))
    inside = (parts[owner] >= 0) & (parts[graph.neighbours] >= 0)
    assert (parts[owner] == parts[graph.neighbours])[inside].all()


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("count", [2, 3, 7])
def test_no_instance_reads_two_interiors(name: str, count: int) -> None:
    layout, store, system, graph = whole(PROBLEMS[name]())
    parts = by_separators(graph, count)
    assert_separated(graph, parts)
    assert len(np.unique(parts[parts >= 0])) == count
    of_instances = part_of_instances(graph.blocks, parts, count)
    shares = shares_of(store, layout, system, graph, parts, of_instances)
    for number, group in enumerate(layout.groups):
        rows = [share.rows[group.table][share.active[number]] for share in shares]
        np.testing.assert_array_equal(
            np.sort(np.concatenate(rows)), np.arange(store.tables[group.table].size)
        )
    interiors = np.concatenate([share.blocks[share.interior] for share in shares])
    assert len(np.unique(interiors)) == len(interiors)


def path(n: int) -> Graph:
    """A path of n vertices."""
    start = np.concatenate(([0], np.cumsum([1, *[2] * (n - 2), 1])))
    ends = [[k for k in (v - 1, v + 1) if 0 <= k < n] for v in range(n)]
    return Graph(
        start,
        np.array([other for both in ends for other in both]),
        np.ones(n, dtype=np.int64),
        np.ones(n, dtype=np.int64),
        (),
    )


def test_labels_make_the_parts() -> None:
    labels = np.repeat([0, 1, 2], 4)
    labels[[5, 6]] = -1
    parts = by_labels(path(12), labels)
    assert_separated(path(12), parts)
    assert (parts == BOUNDARY).sum() == 2
    assert sorted(np.unique(parts)) == [BOUNDARY, 0, 1, 2]


def test_neighbouring_labels_share_a_part() -> None:
    parts = by_labels(path(40), np.arange(40) // 4, 3)
    assert_separated(path(40), parts)
    assert len(np.unique(parts[parts >= 0])) == 3
    assert (parts == BOUNDARY).sum() == 2


def test_a_path_is_split_into_even_parts() -> None:
    parts = by_separators(path(400), 4)
    sizes = np.bincount(parts[parts >= 0])
    assert len(sizes) == 4
    assert sizes.max() < 1.5 * sizes.min()
    assert (parts == BOUNDARY).sum() == 3


def test_cameras_separate_points() -> None:
    # A camera is read by many instances, and still a smaller boundary than its points.
    model = PROBLEMS["bundle"](24, 400)
    parts = by_separators(whole(model)[3], 3)
    between = np.flatnonzero(parts == BOUNDARY)
    assert 0 < len(between) <= 16
    assert (between >= 25).sum() <= 3
