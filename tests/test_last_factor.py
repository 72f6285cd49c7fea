"""Ends that the factor of the last linearisation shows, and secant steps: both save attempts."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arael.runtime.linear import compiled as solvers
from tests.interpreted import Load, loader
from tests.test_ending_families import CURVE, PLANE, curve

# The Gauss-Newton step from y = 0 ends where `h` has its old value and nearly no slope; its root
# is at 2.2. The constant gives the cost a scale.
HIDDEN = """
root A {
    param x: real = 0
    param y: real = 0
    constraint c {
        let h = 1 - y + 2.0001*y*y - 1.0001*y^3
        [10, x - 1, 0.01*h]
    }
}
"""
# The same along the difference of two parameters, whose own curvatures stay.
HIDDEN_DIFFERENCE = """
root A {
    param u: real = 0
    param v: real = 0
    constraint c {
        let y = u - v
        let h = 1 - y + 2.0001*y*y - 1.0001*y^3
        [10, u + v - 1, 0.01*h]
    }
}
"""


# The first step goes to z = 1, where `f` has the value `left` and 80 times its slope at 0: the last
# matrix promises 6400 times as much of it as the new one.
GROWS = """
root A {
    left: real
    param x: real = 0
    param z: real = 0
    constraint c {
        let f = -0.01 + 0.01*z + (3*left - 0.79)*z^2 + (0.79 - 2*left)*z^3
        [10, x - 1, f]
    }
}
"""
# That beside a difference whose curvature the step loses, as above.
GROWS_BESIDE = """
root A {
    left: real
    param u: real = 0
    param v: real = 0
    param z: real = 0
    constraint c {
        let y = u - v
        let h = 1 - y + 2.0001*y*y - 1.0001*y^3
        let f = -0.01 + 0.01*z + (3*left - 0.79)*z^2 + (0.79 - 2*left)*z^3
        [10, u + v - 1, 0.01*h, f]
    }
}
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    """Load a model's text, once each, without compiling it."""
    return loader(tmp_path_factory.mktemp("last"))


def promise(model: Any) -> float:
    """``g' H^-1 g`` at the state of a model."""
    rows = model.jacobian()
    jacobian, r = rows.dense(), rows.residuals
    step = np.linalg.lstsq(jacobian, -r, rcond=None)[0]
    return float(np.square(jacobian @ step).sum())


def curves(kind: Any, scale: float) -> Any:
    for draw in range(12):
        x, y, true = curve(np.random.default_rng(draw))
        start = true * np.random.default_rng(draw).uniform(0.7, 1.3, 3)
        model = kind(**dict(zip("abc", start, strict=True)), s=scale)
        model.points.extend(x=x, y=y)
        yield model


def planes(kind: Any, scale: float) -> Any:
    for draw in range(12):
        rng = np.random.default_rng(draw)
        p = rng.normal(size=(15, 2))
        q = p @ np.array([[0.9, 0.4], [-0.4, 0.9]]) + 0.1 * rng.normal(size=p.shape)
        model = kind(s=scale)
        model.matches.extend(p=p, q=q)
        yield model


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(("text", "family"), [(CURVE, curves), (PLANE, planes)])
def test_the_promise_of_the_last_factor_is_that_of_a_new_one(
    load: Load, text: str, family: Any, scale: float
) -> None:
    saved = 0
    kind = load(text.replace("WHEN ", "").replace("LOSS ", ""))
    for model, twin in zip(family(kind, scale), family(kind, scale), strict=True):
        result = model.solve(rel_precision=1e-7)
        assert result.status == "converged"
        last = result.history[-1]
        if last["promise"] <= 1e-7 * last["cost"]:
            continue
        saved += 1
        assert result.predicted_decrease <= 1e-7 * result.end_cost
        # A twin that may not end so soon stays where the last attempt came to.
        before = twin.solve(rel_precision=0, max_iters=result.iterations)
        assert before.end_cost == pytest.approx(float(last["trial_cost"]), rel=1e-12)
        assert result.predicted_decrease == pytest.approx(promise(twin), rel=0.3, abs=1e-14)
        # The step that showed the end is taken, and brings most of what was left.
        assert result.end_cost <= before.end_cost
        assert promise(model) <= 0.2 * promise(twin) + 1e-14
    assert saved >= 6


@pytest.mark.parametrize("text", [HIDDEN, HIDDEN_DIFFERENCE], ids=["scalar", "difference"])
def test_a_direction_that_loses_its_curvature_is_no_end(load: Load, text: str) -> None:
    """In the matrix before, its gradient is nothing: 1e-12 of what is left to gain."""
    model = load(text)()
    first = model.solve(max_iters=1)
    assert first.end_cost == pytest.approx(100 + 1e-4, rel=1e-9)
    assert promise(model) == pytest.approx(1e-4, rel=1e-6)
    assert first.status == "max_iterations"
    result = load(text)().solve()
    assert result.status == "converged"
    assert result.end_cost == pytest.approx(100, rel=1e-9)


@pytest.mark.parametrize(("precision", "left"), [("f64", 1e-4), ("f32", 1e-2)])
def test_curvature_that_has_grown_takes_one_attempt_more(
    load: Load, precision: str, left: float
) -> None:
    """The last factor promises thousands of times what is left."""
    result = load(GROWS, precision)(left=left).solve(rel_precision=1e-7 if left < 1e-3 else 1e-4)
    assert (result.status, result.iterations) == ("converged", 2)
    assert result.end_cost == pytest.approx(100, rel=1e-6)


def test_what_is_left_in_grown_curvature_is_no_end(load: Load) -> None:
    model = load(GROWS)(left=4e-3)
    assert model.solve(max_iters=1).end_cost == pytest.approx(100 + 1.6e-5, rel=1e-12)
    assert promise(model) == pytest.approx(1.6e-5, rel=1e-6)
    result = load(GROWS)(left=4e-3).solve(rel_precision=1e-7)
    assert result.status == "converged" and result.iterations > 1
    assert result.end_cost <= 100 * (1 + 1e-7)


def test_grown_curvature_hides_no_direction_that_loses_its_own(load: Load) -> None:
    model = load(GROWS_BESIDE)(left=1e-4)
    model.solve(max_iters=1)
    assert promise(model) == pytest.approx(1e-4, rel=1e-3)
    result = load(GROWS_BESIDE)(left=1e-4).solve(rel_precision=1e-7)
    assert result.status == "converged"
    assert result.end_cost == pytest.approx(100, rel=1e-7)


def test_a_linear_problem_takes_one_attempt(load: Load) -> None:
    model = load("root A { param x: real = 0\n constraint c { [x - 1, 2*x + 3] } }")()
    result = model.solve()
    assert (result.status, result.iterations) == ("converged", 1)
    assert float(model.x.value) == pytest.approx(-1.0, abs=1e-12)


@pytest.mark.parametrize("settings", [{"patience": 1}, {"min_diagonal": 1e-3}, {"min_iters": 2}])
def test_settings_that_ask_for_more_attempts_get_them(load: Load, settings: Any) -> None:
    model = load("root A { param x: real = 0\n constraint c { [x - 1, 2*x + 3] } }")()
    assert model.solve(**settings).iterations >= 2


def test_a_bounded_component_takes_its_last_attempt(load: Load) -> None:
    """Bounds change the system from one linearisation to the next."""
    model = load("root A { param x: real in -9 .. 9 = 0\n constraint c { [x - 1, 2*x + 3] } }")()
    assert model.solve().iterations == 2


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize(("bend", "most"), [(0.5, 7), (0.8, 10)])
def test_secant_steps_at_large_residuals(
    load: Load, bend: float, most: int, precision: str
) -> None:
    """Gauss-Newton multiplies the error by `bend`: alone it takes 18 and 46 attempts.

    Madsen, Nielsen and Tingleff, "Methods for non-linear least squares problems", 2004.
    """
    model = load(
        f"root A {{ param x: real = 0.2\n constraint c {{ [x + 1, {bend}*x*x + x - 1] }} }}",
        precision,
    )()
    result = model.solve(rel_precision=1e-12)
    assert result.status == "converged" and result.iterations <= most
    assert float(model.x.value) == pytest.approx(0, abs=1e-7 if precision == "f64" else 2e-2)


class Failing:
    """A factor as of scikit-sparse, whose `solve` fails from the second call on."""

    def __init__(self, matrix: Any) -> None:
        self.calls = 0

    def factorise(self, matrix: Any) -> int:
        lower = matrix.toarray()
        self.matrix = lower + np.tril(lower, -1).T
        return -1

    def solve(self, right: Any) -> Any:
        self.calls += 1
        if self.calls > 1:
            raise MemoryError("no workspace")
        return np.linalg.solve(self.matrix, right)


def test_a_solver_that_fails_there_ends_the_solve(
    load: Load, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its right-hand side is left as it was, which would pass for a small step."""
    monkeypatch.setattr(solvers, "new_factor", Failing)
    monkeypatch.setattr(solvers, "OpenMP", lambda: SimpleNamespace(on_one_thread=nullcontext))
    model = load("root A { param x: real = 0\n constraint c { [x - 1, 2*x + 3] } }")()
    with pytest.raises(MemoryError, match="no workspace"):
        model.solve(solver="cholmod")
