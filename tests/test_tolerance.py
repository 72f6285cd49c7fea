"""The default tolerance: large problems end soon at the best cost, small ones have many digits."""

from __future__ import annotations

from typing import Any

import pytest

import arael
from arael import LmConfig
from tests.public_data import public

ATTEMPTS = {
    "pose_graph_2d/M3500": 2,
    "pose_graph_2d/ringCity": 3,
    "pose_graph_3d/tinyGrid3D": 4,
    "pose_graph_3d/smallGrid3D": 4,
    "pose_graph_3d/parking-garage": 3,
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
    assert result.predicted_decrease <= 1e-7 * result.end_cost
    least = graph.solve(rel_precision=1e-14).end_cost
    assert least <= result.end_cost <= least * (1 + 2e-7)


@pytest.mark.parametrize("single", [False, True])
def test_small_problems_go_on_to_many_digits(single: bool) -> None:
    assert LmConfig().relative(33, single) == 1e-7
    assert LmConfig().relative(32, single) == (1e-10 if single else 1e-14)
    assert LmConfig(strategy="damped").relative(32, single) == 1e-10
    assert LmConfig(rel_precision=1e-3).relative(33, single) == 1e-3


def test_little_that_no_step_realises_counts_as_none_up_to_less() -> None:
    assert LmConfig().enough == 1e-10
    assert LmConfig(rel_precision=1e-3).enough == 1e-3


def test_the_reference_keeps_its_rule() -> None:
    reference = LmConfig.reference()
    assert (reference.rel_precision, reference.ending) == (1e-4, "small_steps")
