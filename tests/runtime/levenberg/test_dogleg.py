"""Steps of the dogleg against an independent one in dense NumPy."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from arael.config import LmConfig
from arael.runtime.levenberg.compiled import Minimiser
from arael.runtime.linear.compiled import DenseSolver
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
                newton=vectors.newton_array.astype(float),
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


def is_secant(attempt):
    """Whether a step inside the region is another than the Gauss-Newton step."""
    step, newton = attempt.step, attempt.newton
    inside = step @ (attempt.scale * step) < attempt.record["radius"] ** 2 * (1 - 1e-6)
    return inside and not np.allclose(step, newton, rtol=1e-4, atol=1e-9 * abs(newton).max())


def test_secant_steps_are_those_of_a_bfgs_update():
    """Of J'J, by the last step and the change of the gradient, and two Gauss-Newton steps."""
    secants = 0
    for start in starts(40):
        watcher, states = watched(start)
        pairs = zip(watcher.attempts, watcher.attempts[1:], states, states[1:], strict=False)
        for before, attempt, x0, x in pairs:
            if not is_secant(attempt):
                continue
            secants += 1
            assert before.record["accepted"] and attempt.record["retry"] == 0
            g = jacobian(x).T @ residual(x)
            s, y = before.step, g - jacobian(x0).T @ residual(x0)
            n, u = attempt.newton, before.newton - attempt.newton
            a = (s @ g) / (s @ y)
            b = y @ (-n - a * u) / (s @ y)
            expected = -((-n - a * u) + s * (a - b))
            np.testing.assert_allclose(attempt.step, expected, rtol=1e-5)
            # The update of H meets the secant equation: the step is exact along s.
            assert attempt.record["predicted"] == pytest.approx(-g @ attempt.step, rel=1e-9)
    assert secants > 3


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
            if (precision == "f32" and record["cost"] < 1e-3) or is_secant(attempt):
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
            if not record["accepted"] and is_secant(attempt):
                case, expected = "secant", record["radius"]
            elif not record["accepted"]:
                case, expected = "rejected", length / 4
            elif gain > 0.75:
                case, expected = "good", max(record["radius"], 2 * length)
            elif gain < 0.25:
                case, expected = "poor", length / 2
            else:
                case, expected = "fair", record["radius"]
            seen.add(case)
            assert attempt.next_radius == pytest.approx(expected, rel=1e-9)
    assert seen - {"secant"} == {"rejected", "good", "poor", "fair"}


def test_first_radius_is_no_longer_than_the_state():
    """Measured in scaled variables, as the step is."""
    for start in starts(6):
        watcher, _ = watched(start)
        scale = (jacobian(start) ** 2).sum(axis=0)
        size = np.sqrt(scale @ np.square(start))
        step = oracle(np.array(start), scale, 1e-12, np.inf)[1]
        newton = np.sqrt(step @ (scale * step))
        assert watcher.attempts[0].record["radius"] == pytest.approx(min(size, newton), rel=1e-6)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("start", [0.0, 1e-12, 1e-18, 1e-25])
def test_first_step_ignores_the_length_of_a_state_that_is_nearly_zero(start, precision):
    """A step so short changes no cost: it was rejected, shortened, and the solve stalled."""
    layout = toys.root_only(1, lambda x: [x[0] / 10, 0.9 - x[0]], precision)
    problem = Problem(layout, toys.at(layout, start))
    solver = DenseSolver(problem.structure.pattern, precision == "f32")
    config = LmConfig.of(strategy="dogleg")
    watcher = Watcher()
    minimiser = Minimiser(problem.evaluation, solver, problem.box, config, watcher, True)
    assert minimiser.run() == "converged"
    assert minimiser.current_cost == pytest.approx(0.81 * 0.01 / 1.01, rel=1e-5)
    assert len(watcher.attempts) <= 3


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
