"""Requests have all that it takes: repeated, or answered by a process that knows nothing."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from arael.distributed.parts import requests, team
from arael.distributed.parts.executors import InProcess
from arael.distributed.parts.solve import Solved, prepare, run

from .problems import PROBLEMS, arrays_of


class Forgetful(InProcess):
    """Many requests reach a process that has kept nothing."""

    def __init__(self) -> None:
        super().__init__()
        self._chance = random.Random(3)
        self.forgot = 0

    def start(self, function: Callable[..., Any], *args: Any) -> Any:
        if self._chance.random() < 0.15:
            requests._PARTS.clear()
            requests._SYSTEMS.clear()
            self.forgot += 1
        return super().start(function, *args)


class Twice(InProcess):
    """Each request is answered twice, as by a worker that was taken for lost."""

    def start(self, function: Callable[..., Any], *args: Any) -> Any:
        super().start(function, *args)
        return super().start(function, *args)


def solved(name: str, executor: InProcess) -> Solved:
    model = PROBLEMS[name]()
    return run(prepare(model._compiled, arrays_of(model), 3, None), executor)


@pytest.mark.parametrize("small", [0, 10**9])
@pytest.mark.parametrize("executor", [InProcess, Forgetful, Twice])
@pytest.mark.parametrize("name", ["grid", "loop", "fleet"])
def test_lost_and_repeated_requests_change_no_bit(
    name: str, executor: Callable[[], InProcess], small: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = solved(name, InProcess())
    # The boundary is solved on a worker, or in the calling process.
    monkeypatch.setattr(team, "_SMALL", small)
    other = executor()
    found = solved(name, other)
    assert getattr(other, "forgot", 100) > 5
    fields = ["cost", "trial_cost", "predicted", "accepted"]
    assert found.result.history[fields].tolist() == expected.result.history[fields].tolist()
    np.testing.assert_array_equal(found.result.x, expected.result.x)


def test_a_solve_with_a_forgetful_cluster_has_the_same_marginals() -> None:
    expected, found = solved("loop", InProcess()), solved("loop", Forgetful())
    np.testing.assert_array_equal(
        found.covariance().marginal("poses", 20), expected.covariance().marginal("poses", 20)
    )


def test_a_boundary_on_a_worker_gives_the_same_marginals(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = solved("loop", InProcess())
    monkeypatch.setattr(team, "_SMALL", 0)
    found = solved("loop", Forgetful())
    on_boundary = int(expected.team.scalars[0]) // 3
    for row in (20, on_boundary):
        np.testing.assert_array_equal(
            found.covariance().marginal("poses", row), expected.covariance().marginal("poses", row)
        )


def test_a_worker_that_lost_the_factor_of_the_boundary_makes_it_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """For a marginal no part has a right-hand side: only their matrices are missing."""
    monkeypatch.setattr(team, "_SMALL", 0)
    found = solved("loop", InProcess())
    covariance = found.covariance()
    on_boundary = int(found.team.scalars[0]) // 3
    expected = covariance.marginal("poses", on_boundary)
    requests._SYSTEMS.clear()
    np.testing.assert_array_equal(covariance.marginal("poses", on_boundary), expected)


def test_what_parts_have_is_not_sent_again() -> None:
    # Whole gradients, solutions and factors stay with the parts: 40 bytes a scalar and attempt,
    # and a few of the boundary.
    found = solved("loop", InProcess())
    attempts = found.result.iterations
    assert found.traffic.out + found.traffic.back < 40 * 1.3 * (attempts + 1) * found.split.size


def test_a_process_keeps_the_parts_of_the_last_runs_only() -> None:
    for _ in range(4):
        solved("loop", InProcess())
    assert len({name.run for name in requests._PARTS}) <= 2
