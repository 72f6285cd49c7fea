"""Each strategy that has a name: its steps, and its ends on families of problems."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arael.result import Result
from tests.interpreted import Load, loader
from tests.test_endings import LINEAR, PRECISIONS, ROBUST, ROSENBROCK, SATURATION, SQUARE

STRATEGIES = ("dogleg", "damped")
BOUNDED = """
root A {
    param x: real in -5 .. 0.5 = -1.2
    param y: real = 1
    constraint c { [10*(y - x*x), 1 - x] }
}
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    """Load a model's text, once each, without compiling it."""
    return loader(tmp_path_factory.mktemp("strategies"))


def solved(model: Any, strategy: str, **settings: Any) -> Result:
    """Solve, and check what holds for every end."""
    result = model.solve(strategy=strategy, **settings)
    assert result.end_cost <= result.start_cost
    assert result.end_cost == pytest.approx(model.cost(), rel=1e-6, abs=1e-30)
    accepted = result.history[result.history["accepted"] == 1]
    assert (accepted["trial_cost"] < accepted["cost"]).all()
    return result


def test_rejected_attempts_factorise_nothing_anew(load: Load) -> None:
    result = solved(load(ROSENBROCK)(s=1.0), "dogleg")
    assert result.iterations > result.accepted_iterations
    assert len(np.unique(result.history["iteration"])) <= result.accepted_iterations + 1


# --- the ends ---------------------------------------------------------------------------------


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_units_of_the_residuals_do_not_matter(
    load: Load, precision: str, strategy: str, scale: float
) -> None:
    model = load(ROSENBROCK, precision)(s=scale)
    assert solved(model, strategy).status == "converged"
    near = 1e-9 if precision == "f64" else 1e-3
    np.testing.assert_allclose([model.x.value, model.y.value], 1, rtol=near)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_exact_and_linear_problems_converge(load: Load, precision: str, strategy: str) -> None:
    rng = np.random.default_rng(2)
    near = 1e-9 if precision == "f64" else 1e-4
    for t in np.exp(rng.uniform(-7, 7, 15)):
        model = load(SQUARE, precision)(t=t)
        assert solved(model, strategy).status == "converged"
        assert float(model.v.value) == pytest.approx(np.sqrt(t), rel=near)
    for k in rng.normal(size=15):
        model = load(LINEAR, precision)(k=k)
        result = solved(model, strategy)
        assert result.status == "converged" and result.iterations <= 4
        assert result.end_cost < (1e-20 if precision == "f64" else 1e-10)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    "loss", ["huber(1)", "cauchy(1)", "geman_mcclure(1)", "tukey(1)", "dcs(1)"]
)
def test_losses_end_where_the_default_ends(load: Load, strategy: str, loss: str) -> None:
    rng = np.random.default_rng(5)
    kind = load(ROBUST.replace("LOSS", loss))
    x = np.linspace(-1, 1, 15)
    for _ in range(5):
        y = 0.7 * x - 0.2 + 0.1 * rng.normal(size=15)
        y[::5] += 3 * rng.normal(size=3)
        ends = []
        for one in ("auto", strategy):
            model = kind(a=0.6, b=-0.1, s=3.0)
            model.points.extend(x=x, y=y)
            result = solved(model, one)
            assert result.status == "converged"
            ends.append(result.end_cost)
        assert ends[1] == pytest.approx(ends[0], rel=1e-6)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_bounds_hold(load: Load, strategy: str) -> None:
    model = load(BOUNDED)()
    assert solved(model, strategy).status == "converged"
    np.testing.assert_allclose([model.x.value, model.y.value], [0.5, 0.25], rtol=1e-6)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_jump_of_the_cost_is_no_convergence(load: Load, strategy: str) -> None:
    model = load(
        "root A { param x: real = 0.5\n    constraint a { x - 2 }\n"
        "    constraint k when x >= 1 { 10 + 1e-9*x }\n}\n"
    )()
    result = solved(model, strategy)
    assert not result.converged
    assert result.end_cost == pytest.approx(1, rel=1e-5)


def test_saturation_from_a_start_on_its_plateau(load: Load) -> None:
    x = np.array([1.0, 2, 3, 5, 7, 10])
    model = load(SATURATION)(a=1.0, b=1.0)
    model.points.extend(x=x, y=210 * (1 - np.exp(-0.55 * x)))
    assert solved(model, "dogleg").status == "converged"
    np.testing.assert_allclose([model.a.value, model.b.value], [210, 0.55], rtol=1e-5)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_components_end_as_each_does_alone(load: Load, strategy: str) -> None:
    kind = load(
        "struct One { param v: real = 2\n t: real\n constraint c { v*v - t } }\n"
        "root A { ones: list of One }\n"
    )
    both, alone = kind(), kind()
    both.ones.extend(v=[2.0, 2.0], t=[9.0, 1e-3])
    alone.ones.extend(v=[2.0], t=[1e-3])
    solved(alone, strategy)
    assert solved(both, strategy).status == "converged"
    assert float(both.ones.v.value[1]) == pytest.approx(float(alone.ones.v.value[0]), rel=1e-12)
