"""A solve in parts is the solve on one machine: same attempts, same costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arael.distributed.parts.executors import InProcess
from arael.distributed.parts.solve import prepare, run

from .problems import PROBLEMS, arrays_of


def in_parts(model: Any, parts: int | None, by: str | None = None, **settings: Any) -> Any:
    prepared = prepare(model._compiled, arrays_of(model), parts, by)
    return run(prepared, InProcess(), **settings)


def assert_equal(found: Any, alone: Any) -> None:
    assert found.result.status == alone.status
    assert found.result.iterations == alone.iterations
    np.testing.assert_array_equal(found.result.history["accepted"], alone.history["accepted"])
    np.testing.assert_allclose(found.result.history["cost"], alone.history["cost"], rtol=1e-8)
    assert found.result.cost == pytest.approx(alone.cost, rel=1e-9)
    np.testing.assert_allclose(found.result.x, alone.x, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("parts", [2, 5])
def test_attempts_and_costs_are_those_of_one_machine(name: str, parts: int) -> None:
    model = PROBLEMS[name]()
    found = in_parts(model, parts)
    assert found.split.parts == parts
    assert_equal(found, model.solve(solver="sparse"))


def test_parts_by_a_column_are_equal_too() -> None:
    model = PROBLEMS["bundle"]()
    found = in_parts(model, None, "session")
    assert found.split.parts == 2
    assert_equal(found, model.solve(solver="sparse"))


def bounded_grid() -> Any:
    """Nodes of the grid, of the boundaries between parts as well, that end at bounds."""
    field: Any = PROBLEMS["grid"]()
    free = field.copy()
    free.solve(solver="sparse")
    h = np.array(free.nodes.h)
    for k in range(0, len(h), 3):
        field.nodes[k].h.high = float(h[k]) - 0.05
    for k in range(1, len(h), 4):
        least = float(free.nodes.s[k, 0]) + 0.02
        field.nodes[k].s.low = [least, None]
        field.nodes[k].s = [max(1.0, least), 1.0]
    field.nodes.h = np.minimum(np.array(field.nodes.h), np.array(field.nodes.h.high))
    return field


def bounded_bundle() -> Any:
    scene: Any = PROBLEMS["bundle"]()
    scene.focal.low = 1.002
    scene.focal = 1.01
    for k in range(0, len(scene.points), 5):
        scene.points[k].x.high = [float(scene.points.x[k, 0]) + 0.01, None]
    return scene


def bounded_loop() -> Any:
    graph: Any = PROBLEMS["loop"]()
    for k in range(2, len(graph.poses), 4):
        x, y = graph.poses.t[k]
        graph.poses[k].t.low = [float(x) - 0.02, float(y) - 0.02]
        graph.poses[k].t.high = [float(x) + 0.02, float(y) + 0.02]
    return graph


BOUNDED = {"grid": bounded_grid, "bundle": bounded_bundle, "loop": bounded_loop}


@pytest.mark.parametrize("name", BOUNDED)
@pytest.mark.parametrize("parts", [2, 3])
@pytest.mark.parametrize("strategy", ["auto", "damped"])
def test_bounds_hold_as_on_one_machine(name: str, parts: int, strategy: str) -> None:
    model = BOUNDED[name]()
    found = in_parts(model, parts, strategy=strategy)
    free = in_parts(PROBLEMS[name](), parts)
    alone = model.solve(solver="sparse", strategy=strategy)
    assert_equal(found, alone)
    assert found.result.cost > free.result.cost + 1e-6


def test_bounds_hold_in_parts_by_a_column() -> None:
    model = bounded_bundle()
    found = in_parts(model, None, "session")
    assert_equal(found, model.solve(solver="sparse"))


@pytest.mark.parametrize(
    "name, collection, rows",
    [("bundle", "points", (0, 5)), ("loop", "poses", (2, 17)), ("grid", "nodes", (0, 3, 4))],
)
def test_what_stands_on_a_bound_has_no_variance(
    name: str, collection: str, rows: tuple[int, ...]
) -> None:
    model = BOUNDED[name]()
    covariance = in_parts(model, 3).covariance()
    model.solve(solver="sparse")
    alone = model.covariance()
    for row in rows:
        expected = alone.marginal((collection, row))
        found = covariance.marginal(collection, row)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-12)
        assert len(covariance.names(collection, row)) == len(expected)


def test_the_damped_strategy_is_the_same_loop() -> None:
    model = PROBLEMS["grid"]()
    found = in_parts(model, 3, strategy="damped")
    assert_equal(found, model.solve(solver="sparse", strategy="damped"))


def test_one_part_has_no_boundary() -> None:
    model = PROBLEMS["chain"]()
    found = in_parts(model, 1)
    assert found.split.between == 0
    assert_equal(found, model.solve(solver="sparse"))


@pytest.mark.parametrize(
    "name, collection, rows",
    [("loop", "poses", (0, 17, 59)), ("bundle", "points", (0, 20)), ("bundle", "", (0,))],
)
def test_marginals_are_those_of_one_machine(
    name: str, collection: str, rows: tuple[int, ...]
) -> None:
    model = PROBLEMS[name]()
    covariance = in_parts(model, 4).covariance()
    model.solve(solver="sparse")
    alone = model.covariance()
    for row in rows:
        expected = alone.marginal((collection, row) if collection else model)
        np.testing.assert_allclose(
            covariance.marginal(collection, row), expected, rtol=1e-5, atol=1e-8
        )


def test_a_boundary_entity_has_a_marginal() -> None:
    model = PROBLEMS["loop"]()
    found = in_parts(model, 4)
    first = int(found.team.scalars[0]) // 3
    model.solve(solver="sparse")
    np.testing.assert_allclose(
        found.covariance().marginal("poses", first),
        model.covariance().marginal(("poses", first)),
        rtol=1e-5,
    )
