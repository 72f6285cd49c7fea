"""Steps of the dogleg against an independent one in dense NumPy."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from arael.config import LmConfig
from arael.runtime.levenberg.loop import Minimiser
from arael.runtime.linear.dense import DenseSolver
from arael.runtime.problem import Problem
from tests.runtime import toys


def formula(x):
    return [10 * (x[1] - x[0] * x[0]), 1 - x[0], x[2] * x[1] - 2, (x[2] * x[2] - x[0]) * 0.1]


def residual(x):
    return np.array(formula(x))


def jacobian(x):
    return np.array(
        [
            [-20 * x[0], 10, 0],
            [-1, 0, 0],
            [0, x[2], x[1]],
            [-0.1, 0, 0.2 * x[2]],
        ]
    )


class Watcher:
    """Keeps, of each attempt, the record, the step and the state it starts from."""

    def __init__(self) -> None:
        self.attempts: list[SimpleNamespace] = []
        self.factorisations = 0

    def started(self, minimiser):
        pass

    def stepped(self, minimiser, record):
        vectors = minimiser.vectors
        self.factorisations = minimiser.factorisations
        self.attempts.append(
            SimpleNamespace(
                record=record,
                step=vectors.step_array.astype(float),
                scale=vectors.scale_array.astype(float),
                next_radius=minimiser.dogleg.radius,
            )
        )
        return True


def watched(start, precision="f64", low=(), high=(), **settings):
    layout = toys.root_only(3, formula, precision, low, high)
    problem = Problem(layout, toys.at(layout, *start))
    solver = DenseSolver(problem.structure.pattern, precision == "f32")
    watcher = Watcher()
    config = LmConfig.of(strategy="dogleg", **settings)
    minimiser = Minimiser(problem.evaluation, solver, problem.box, config, watcher, True)
    minimiser.run()
    x, at = np.array(start, dtype=float), []
    for attempt in watcher.attempts:
        at.append(x.copy())
        if attempt.record["accepted"]:
            x = x + attempt.step
    return watcher, at


def starts(count=12):
    rng = np.random.default_rng(7)
    return [tuple(x) for x in rng.normal(size=(count, 3)) * rng.choice([0.3, 3, 30], (count, 1))]


def oracle(x, scale, regularisation, radius):
    """The dogleg of one linearisation: kind, step, predicted decrease of ``|r + J s|^2``."""
    r, j = residual(x), jacobian(x)
    g, h = j.T @ r, j.T @ j
    newton = np.linalg.solve(h + regularisation * np.diag(scale), -g)
    descent = -g / scale
    corner = (g @ -descent) / (descent @ h @ descent) * descent

    def length(s):
        return np.sqrt(s @ (scale * s))

    if length(newton) <= radius:
        kind, step = "newton", newton
    elif length(corner) >= radius:
        kind, step = "descent", corner * radius / length(corner)
    else:
        # Bisection on the second leg, along which lengths grow.
        low, high = 0.0, 1.0
        for _ in range(80):
            middle = (low + high) / 2
            if length(corner + middle * (newton - corner)) < radius:
                low = middle
            else:
                high = middle
        kind, step = "corner", corner + low * (newton - corner)
    return kind, step, -(2 * g @ step + step @ h @ step)


@pytest.mark.parametrize("precision, tolerance", [("f64", 1e-7), ("f32", 2e-2)])
def test_steps_lie_on_the_dogleg_and_predict_what_the_model_does(precision, tolerance):
    kinds = set()
    for start in starts():
        watcher, states = watched(start, precision)
        for attempt, x in zip(watcher.attempts, states, strict=True):
            record = attempt.record
            j = jacobian(x)
            if np.linalg.cond(j / np.sqrt(attempt.scale)) > 1e3 or not record["factored"]:
                continue  # digits of the oracle itself are lost
            if precision == "f32" and record["cost"] < 1e-3:
                continue
            kind, step, predicted = oracle(x, attempt.scale, record["damping"], record["radius"])
            kinds.add(kind)
            close = {"rtol": tolerance, "atol": tolerance * np.abs(step).max()}
            np.testing.assert_allclose(attempt.step, step, **close)
            length = np.sqrt(attempt.step @ (attempt.scale * attempt.step))
            assert length <= record["radius"] * (1 + tolerance)
            if kind != "newton":
                assert length == pytest.approx(record["radius"], rel=tolerance)
            assert record["predicted"] == pytest.approx(
                predicted, rel=10 * tolerance, abs=1e-9 * record["cost"]
            )
            assert record["predicted"] <= record["promise"] * (1 + tolerance)
    assert kinds == {"newton", "corner", "descent"}


def test_scale_is_the_largest_diagonal_so_far():
    for start in starts(4):
        watcher, states = watched(start)
        largest = np.zeros(3)
        for attempt, x in zip(watcher.attempts, states, strict=True):
            largest = np.maximum(largest, (jacobian(x) ** 2).sum(axis=0))
            np.testing.assert_allclose(attempt.scale, largest, rtol=1e-12)


def test_a_rejected_step_makes_no_new_factorisation():
    rejected = 0
    for start in starts():
        watcher, _ = watched(start)
        records = [attempt.record for attempt in watcher.attempts]
        assert watcher.factorisations == sum(r["retry"] == 0 for r in records)
        rejected += sum(not r["accepted"] for r in records)
    assert rejected > 10


def test_radius_follows_the_gain_ratio():
    seen = set()
    for start in starts():
        watcher, _ = watched(start)
        for attempt in watcher.attempts:
            record = attempt.record
            length = np.sqrt(attempt.step @ (attempt.scale * attempt.step))
            gain = (record["cost"] - record["trial_cost"]) / record["predicted"]
            if not record["accepted"]:
                case, expected = "rejected", length / 4
            elif gain > 0.75:
                case, expected = "good", max(record["radius"], 2 * length)
            elif gain < 0.25:
                case, expected = "poor", length / 2
            else:
                case, expected = "fair", record["radius"]
            seen.add(case)
            assert attempt.next_radius == pytest.approx(expected, rel=1e-9)
    assert seen == {"rejected", "good", "poor", "fair"}


def test_first_radius_is_no_longer_than_the_state():
    """Measured in scaled variables, as the step is."""
    for start in starts(6):
        watcher, _ = watched(start)
        scale = (jacobian(start) ** 2).sum(axis=0)
        size = np.sqrt(scale @ np.square(start))
        step = oracle(np.array(start), scale, 1e-12, np.inf)[1]
        newton = np.sqrt(step @ (scale * step))
        assert watcher.attempts[0].record["radius"] == pytest.approx(min(size, newton), rel=1e-6)


def test_steps_stay_inside_bounds_and_predict_what_the_cut_step_does():
    cut = 0
    for start in starts():
        start = tuple(np.clip(start, -2, 2))
        watcher, states = watched(start, low=(-2.0,) * 3, high=(2.0,) * 3)
        for attempt, x in zip(watcher.attempts, states, strict=True):
            assert (np.abs(x + attempt.step) <= 2 + 1e-12).all()
            r, j, record = residual(x), jacobian(x), attempt.record
            at_bound = np.abs(np.abs(x + attempt.step) - 2) < 1e-12
            if not at_bound.any() or np.abs(np.abs(x) - 2).min() < 1e-12:
                continue  # a scalar that is held at its bound is no part of the system
            cut += 1
            step = attempt.step
            predicted = r @ r - np.square(r + j @ step).sum()
            assert record["predicted"] == pytest.approx(predicted, rel=1e-8, abs=1e-10 * (r @ r))
    assert cut > 3
