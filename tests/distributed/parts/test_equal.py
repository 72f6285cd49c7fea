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


@pytest.mark.parametrize("settings", [{"strategy": "damped"}, {"strategy": "subspace"}])
def test_other_strategies_are_the_same_loop(settings: dict[str, str]) -> None:
    model = PROBLEMS["grid"]()
    found = in_parts(model, 3, **settings)
    assert_equal(found, model.solve(solver="sparse", **settings))


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
