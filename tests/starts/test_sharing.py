"""One ordering and symbolic factor for both stages of a start and for the solve after it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear import analysis
from arael.solving import problem_of
from arael.starts.choose import _coupling
from arael.starts.chordal import chordal_poses
from arael.starts.columns import graph_of
from arael.starts.relaxation import Coupling
from tests.starts.test_choose import displaced
from tests.starts.test_chordal import SHAPES


@pytest.fixture
def factors(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the graphs for which a symbolic factor is computed."""
    found: list[int] = []
    compute = analysis.find_supernodes

    def counted(start: Any, neighbours: Any, weights: Any, order: Any) -> Any:
        found.append(len(order))
        return compute(start, neighbours, weights, order)

    monkeypatch.setattr(analysis, "find_supernodes", counted)
    return found


@pytest.mark.parametrize("name", SHAPES)
def test_the_symbolic_factor_is_computed_once_for_start_and_solve(
    name: str, factors: list[int]
) -> None:
    graph = displaced(name)
    assert arael.initialise(graph, "chordal").chosen == "chordal"
    result = graph.solve()
    assert result.converged
    assert factors == [23]


def test_the_shared_order_gives_the_poses_of_an_order_of_its_own() -> None:
    """With a fixed pose in the middle, a half fixed one, and one that is only anchored."""
    graph = displaced("3d")
    graph.poses[7].t.fixed = graph.poses[7].q.fixed = True
    graph.poses[11].t.fixed = True
    graph.anchors.append(pose=9, t=graph.poses[9].t.value, q=graph.poses[9].q.value)
    arrays = graph_of(graph._store)
    coupling = _coupling(problem_of(graph))
    assert coupling is not None
    assert coupling.block_of[[0, 7]].tolist() == [-1, -1]
    alone, shared = chordal_poses(arrays), chordal_poses(arrays, coupling)
    assert np.allclose(shared.position, alone.position, atol=1e-10)
    assert np.allclose(shared.rotation, alone.rotation, atol=1e-10)


def test_a_pattern_without_the_edges_is_not_used() -> None:
    graph = displaced("2d")
    arrays = graph_of(graph._store)
    pattern = BlockPattern.from_pairs(np.full(24, 3), np.array([0]), np.array([1]))
    found = chordal_poses(arrays, Coupling(pattern, np.arange(24)))
    assert np.allclose(found.position, chordal_poses(arrays).position)
