"""The suite `time`: consistency over runs, and its problems."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

import arael
from benchmarks import clocks
from benchmarks.chapters import SUITES


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


def errors(scale: float) -> Any:
    def one(seed: int) -> tuple[Any, Any]:
        root = np.array([[2.0, 0.0], [1.0, 0.5]])
        noise = np.random.default_rng(seed).normal(size=2)
        return scale * root @ noise, root @ root.T

    return one


def test_errors_of_their_covariance_are_consistent_and_others_are_not() -> None:
    right, wrong = (clocks.consistency(errors(scale), 200) for scale in (1.0, 1.3))
    assert right.nees == pytest.approx(2, abs=0.5)
    assert right.consistent
    assert not wrong.consistent
    assert right.sigma == pytest.approx(np.sqrt(1.25))
    assert right.offset == pytest.approx(np.sqrt(1.25), rel=0.2)


@pytest.mark.parametrize("one", [clocks.wheels, clocks.hand_eye, clocks.ranges, clocks.camera_imu])
def test_a_run_of_each_problem(one: Any) -> None:
    off, covariance = one(1)
    assert len(off) == len(covariance)
    assert off @ np.linalg.solve(covariance, off) < 5 * len(off)


def test_the_suite_is_known() -> None:
    assert "time" in SUITES
