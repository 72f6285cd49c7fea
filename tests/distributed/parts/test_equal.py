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
    np.testing.assert_array_equal(
        found.result.history["accepted"], alone.history["accepted"]
    )
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
