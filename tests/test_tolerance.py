"""The tolerance of the standard models: graphs end soon, at the best cost."""

from __future__ import annotations

from typing import Any

import pytest

import arael
from tests.public_data import public

ATTEMPTS = {
    "pose_graph_2d/M3500": 2,
    "pose_graph_2d/intel": 2,
    "pose_graph_2d/ringCity": 3,
    "pose_graph_3d/tinyGrid3D": 4,
    "pose_graph_3d/smallGrid3D": 4,
    "pose_graph_3d/parking-garage": 3,
    "pose_graph_3d/sphere2500": 2,
}


@pytest.mark.parametrize("name", ATTEMPTS)
def test_a_graph_ends_soon_within_a_millionth_of_the_least_cost(name: str) -> None:
    model: Any = arael.load(f"pose_graph_{name[11]}d")
    graph = model()
    graph.read(public(f"{name}.g2o"))
    arael.initialise(graph)
    result = graph.solve()
    assert result.status == "converged"
    assert result.iterations <= ATTEMPTS[name]
    assert result.predicted_decrease <= 1e-6 * result.end_cost
    least = graph.solve(rel_precision=1e-14).end_cost
    assert least <= result.end_cost <= least * (1 + 1e-6)
