"""Which components a problem has, and what is done by component."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from arael.runtime.assembly.compiled import connected
from arael.runtime.assembly.components import partition_of
from arael.runtime.levenberg.compiled import runs_of
from arael.runtime.parallel import vector_parts
from arael.runtime.problem import Problem
from arael.runtime.store import Store
from tests.runtime import toy, toys
from tests.runtime.toy import Raw, Slot, Step

SELF = Slot((), "nodes")


@pytest.mark.parametrize("seed", range(20))
def test_components_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 60))
    edges = rng.integers(0, n, (int(rng.integers(0, n + 1)), 2))
    more = rng.integers(0, n, (int(rng.integers(0, 4)), 2))
    order = np.argsort(edges[:, 0], kind="stable")
    start = np.searchsorted(edges[order, 0], np.arange(n + 1)).astype(np.int64)
    ones, others = (np.ascontiguousarray(column) for column in more.T)
    idle = (rng.random(n) < rng.choice([0, 0.3])).astype(np.uint8)
    count, labels = connected(start, np.ascontiguousarray(edges[order, 1]), ones, others, idle)
    assert (labels[idle != 0] == 0).all()
    every = np.concatenate((edges, more))
    every = every[(idle[every] == 0).all(axis=1)]
    graph = coo_matrix((np.ones(len(every)), (every[:, 0], every[:, 1])), (n, n))
    expected, by_scipy = connected_components(graph, directed=False)
    assert count == expected - idle.sum()
    # Numbered in the order of their first nodes.
    by_scipy = by_scipy[idle == 0]
    _, first, inverse = np.unique(by_scipy, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    np.testing.assert_array_equal(labels[idle == 0], rank[inverse])


def nodes(formula, residuals_of_both: bool = True):
    """Nodes with x and y, each with a link to another node that its constraint reads."""
    table = toy.table(
        "nodes", toy.param("x"), toy.data("t"), toy.ref("to", "nodes")
    )  # fmt: skip
    entity = toy.entity(table)
    group = toy.group(
        "Node.link",
        "nodes",
        [SELF, Slot((Step("ref", "to"),), "nodes")],
        [(0, 0), (1, 0)],
        [entity],
        formula,
        raw=[Raw(0, "t")],
    )
    return toy.layout([toy.table(""), table], [entity], [group])


@pytest.mark.parametrize(
    "formula",
    [
        lambda s, d, u: [s[0][0] - s[1][0] - d[0]],
        lambda s, d, u: [s[0][0] - d[0], s[1][0] * 2.0 - d[0]],  # no residual reads both
    ],
    ids=["coupled", "uncoupled"],
)
def test_instances_join_what_they_read(formula) -> None:
    layout = nodes(formula)
    store = Store(layout)
    to = [1, 0, 3, 3, 2, 0]
    store.tables["nodes"].extend(6, x=np.zeros(6), t=np.arange(6.0), to=to)
    problem = Problem(layout, store)
    partition = partition_of(problem.structure, layout.groups)
    assert partition is not None and partition.count == 2
    assert partition.of_block.tolist() == [0, 0, 1, 1, 1, 0] == partition.of_scalar.tolist()
    assert partition.of_instance[0].tolist() == [0, 0, 1, 1, 1, 0]
    assert partition.first_block.tolist() == [0, 2] and partition.block_counts.tolist() == [3, 3]
    runs = partition.of_values
    assert runs[0, 0] == 0 and runs[-1, 1] == problem.structure.pattern.value_count
    assert (runs[1:, 0] == runs[:-1, 1]).all() and (np.diff(runs[:, 2]) != 0).all()
    # Found once for a structure.
    assert partition_of(problem.structure, layout.groups) is partition


def test_what_is_held_joins_nothing() -> None:
    layout = nodes(lambda s, d, u: [s[0][0] - s[1][0] - d[0]])
    store = Store(layout)
    store.tables["nodes"].extend(5, x=np.zeros(5), t=np.arange(5.0), to=[0, 0, 0, 2, 0])
    assert partition_of(Problem(layout, store).structure, layout.groups) is None
    store.tables["nodes"].fixed("x")[0] = True
    problem = Problem(layout, store)
    partition = partition_of(problem.structure, layout.groups)
    assert partition is not None and partition.of_block.tolist() == [0, 1, 1, 2]
    # The first instance reads nothing that is solved for.
    assert partition.of_instance[0].tolist() == [3, 0, 1, 1, 2]


def test_a_chain_is_one() -> None:
    layout = toys.chain()
    problem = Problem(layout, toys.chain_store(layout, 8))
    assert partition_of(problem.structure, layout.groups) is None


@pytest.mark.parametrize("count", [1, 2, 40])
def test_runs_are_of_one_part_and_one_component(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vector_parts, "GRAIN", 64)
    n = 1000
    component = np.sort(np.random.default_rng(count).integers(0, count, n)).astype(np.int32)
    component[500:] = np.roll(component, 300)[500:]
    parts, whole = runs_of(n)
    runs, ends = runs_of(n, component)
    assert len(whole) == len(ends) == vector_parts.count_parts(n) + 1
    assert len(parts) == len(whole) - 1
    assert runs[0, 0] == 0 and runs[-1, 1] == n and (runs[1:, 0] == runs[:-1, 1]).all()
    np.testing.assert_array_equal(runs[ends[:-1], 0], parts[:, 0])
    for begin, end, label in runs:
        assert (component[begin:end] == label).all()
