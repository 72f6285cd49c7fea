"""Requests have all that it takes: repeated, or answered by a process that knows nothing."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from arael.distributed.parts import requests
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


@pytest.mark.parametrize("executor", [Forgetful, Twice])
@pytest.mark.parametrize("name", ["grid", "loop"])
def test_lost_and_repeated_requests_change_no_bit(
    name: str, executor: Callable[[], InProcess]
) -> None:
    other = executor()
    expected, found = solved(name, InProcess()), solved(name, other)
    assert getattr(other, "forgot", 100) > 20
    fields = ["cost", "trial_cost", "predicted", "accepted"]
    assert found.result.history[fields].tolist() == expected.result.history[fields].tolist()
    np.testing.assert_array_equal(found.result.x, expected.result.x)


def test_a_solve_with_a_forgetful_cluster_has_the_same_marginals() -> None:
    expected, found = solved("loop", InProcess()), solved("loop", Forgetful())
    np.testing.assert_array_equal(
        found.covariance().marginal("poses", 20), expected.covariance().marginal("poses", 20)
    )


def test_a_process_keeps_the_parts_of_the_last_runs_only() -> None:
    for _ in range(4):
        solved("loop", InProcess())
    assert len({name.run for name in requests._PARTS}) <= 2
