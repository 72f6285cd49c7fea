"""How solves end: `converged` is said where, and only where, nothing is left to gain.

Families of random problems, each judged by an independent computation in doubles.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from arael.result import Result
from benchmarks import nist
from tests.interpreted import Load, loader
from tests.public_data import held, public

PRECISIONS = ("f64", "f32")

SQUARE = "root A { param v: real = 2\n t: real\n constraint c { v*v - t } }"
LINEAR = """
root A {
    param x: real = 0
    param y: real = 0
    k: real
    constraint c { [x + y - k, x - 2*y - 0.3] }
}
"""
CIRCLE = """
struct Point { p: vec2
    constraint on { norm(p - root.c) - root.r }
}
root A { param c: vec2 = [0, 0]
    param r: real = 1
    points: list of Point }
"""
ROSENBROCK = """
root A {
    param x: real = -1.2
    param y: real = 1
    s: real
    constraint c { [s*10*(y - x*x), s*(1 - x)] }
}
"""
ROBUST = """
struct Point { x: real
    y: real
    constraint fit loss LOSS { root.s * (root.a * x + root.b - y) }
}
root A { param a: real = 0
    param b: real = 0
    s: real = 1
    points: list of Point }
"""
SATURATION = """
struct Point { x: real
    y: real
    constraint fit { root.a * (1 - exp(-root.b * x)) - y }
}
root A { param a: real
    param b: real
    points: list of Point }
"""
DECAYS = """
struct Point { x: real
    y: real
    constraint fit { root.a + root.b * exp(-root.d * x) + root.c * exp(-root.e * x) - y }
}
root A { param a: real
    param b: real
    param c: real
    param d: real
    param e: real
    points: list of Point }
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    """Load a model's text, once each, without compiling it."""
    return loader(tmp_path_factory.mktemp("endings"))


def solved(model: Any, **settings: Any) -> Result:
    """Solve, and check what holds for every end."""
    result = model.solve(**settings)
    assert result.end_cost <= result.start_cost
    assert result.iterations <= 500
    return result


def nothing_left(residuals: Callable[[Any], Any], x: Any, share: float = 1e-8) -> bool:
    """Whether SciPy, started at x, lowers the cost by no more than `share` of it."""
    cost = float(np.square(residuals(x)).sum())
    if cost < 1e-28:
        return True
    found = least_squares(residuals, x, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return cost - 2 * found.cost <= share * cost


# --- exact solutions, and linear problems -----------------------------------------------------


@pytest.mark.parametrize("precision", PRECISIONS)
def test_roots_of_a_square_converge(load: Load, precision: str) -> None:
    kind = load(SQUARE, precision)
    for t in np.exp(np.random.default_rng(0).uniform(-7, 7, 100)):
        model = kind(t=t)
        assert solved(model).status == "converged"
        assert float(model.v.value) == pytest.approx(
            np.sqrt(t), rel=1e-9 if precision == "f64" else 1e-4
        )


@pytest.mark.sweep(2)
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_linear_problems_converge_in_a_few_steps(load: Load, precision: str, scale: float) -> None:
    kind = load(LINEAR, precision)
    for k in np.random.default_rng(1).normal(size=200) * scale:
        model = kind(k=k)
        result = solved(model)
        assert result.status == "converged" and result.iterations <= 3
        x, y = np.linalg.solve([[1, 1], [1, -2]], [k, 0.3])
        near = {"rtol": 1e-12, "atol": 1e-12 * max(scale, 1)}
        if precision == "f32":
            near = {"rtol": 1e-5, "atol": 1e-6 * max(scale, 1)}
        np.testing.assert_allclose([model.x.value, model.y.value], [x, y], **near)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_circles_through_three_points(load: Load, precision: str) -> None:
    """Every triangle has a circle; from some starts the cost falls forever towards a line."""
    kind = load(CIRCLE, precision)
    lost = 0
    for draw in range(200):
        points = np.random.default_rng(draw).normal(size=(3, 2)) * 3
        model = kind()
        model.points.extend(p=points)
        result = solved(model)
        # In single precision, residuals far out are no more than the rounding of their terms.
        away = np.hypot(*model.c.value) > (1e3 if precision == "f64" else 30)
        if not away:
            assert result.status == "converged", draw
            limit = 1e-20 if precision == "f64" else 1e-9
            x = np.array([*model.c.value, float(model.r.value)], dtype=float)
            assert result.end_cost < limit or nothing_left(
                lambda v, points=points: np.hypot(*(points - v[:2]).T) - v[2],
                x,
                1e-8 if precision == "f64" else 1e-4,
            ), draw
        elif precision == "f64":
            lost += 1
            if result.status == "converged":  # at the rounding of the cost above the best line
                line = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] ** 2
                assert result.end_cost - line < 32 * result.noise_floor, draw
            else:
                assert result.predicted_decrease > result.noise_floor
    assert lost < 30


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("strategy", ["dogleg", "damped"])
@pytest.mark.parametrize("scale", [1e-8, 1e-5, 1e-3, 1.0, 1e3, 1e8])
def test_units_of_the_residuals_do_not_matter(
    load: Load, precision: str, strategy: str, scale: float
) -> None:
    model = load(ROSENBROCK, precision)(s=scale)
    result = solved(model, strategy=strategy)
    assert result.status == "converged"
    near = 1e-9 if precision == "f64" else 1e-3
    np.testing.assert_allclose([model.x.value, model.y.value], 1, rtol=near)


# --- ends that are not converged --------------------------------------------------------------

GUARDS = {
    "one comes in": (
        "root A { param x: real = 0.5\n"
        "    constraint a { x - 2 }\n"
        "    constraint k when x >= 1 { 10 + 1e-9*x }\n}\n"
    ),
    "one for another": (
        "root A { param x: real = 0.5\n"
        "    constraint a when x < 1 { x - 2 }\n"
        "    constraint b when x >= 1 { 3*(x - 0.5) }\n}\n"
    ),
}


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("strategy", ["dogleg", "damped"])
@pytest.mark.parametrize("text", GUARDS.values(), ids=GUARDS)
def test_guards_over_parameters_never_raise_the_cost(
    load: Load, precision: str, strategy: str, text: str
) -> None:
    model = load(text, precision)()
    for most in (1, 500):
        result = solved(model, strategy=strategy, max_iters=most)
        assert result.end_cost == pytest.approx(model.cost(), rel=1e-6)
        accepted = result.history[result.history["accepted"] == 1]
        assert (accepted["trial_cost"] < accepted["cost"]).all()
    assert not result.converged
    # Up to the jump the first residual falls to 1; from there on it costs more.
    assert result.end_cost == pytest.approx(1, rel=1e-5)
    assert result.predicted_decrease == pytest.approx(1, rel=1e-3)
    if strategy == "dogleg":
        assert result.status == "stalled"


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("strategy", ["auto", "dogleg", "damped"])
def test_a_solve_that_cannot_move_has_not_converged(
    load: Load, precision: str, strategy: str
) -> None:
    for settings in (
        {"lambda_floor": 1e10, "lambda_ceiling": 1e15},
        {"min_diagonal": 1e30 if precision == "f32" else 1e300},
    ):
        model = load(ROSENBROCK, precision)(s=1.0)
        result = solved(model, strategy=strategy, **settings)
        assert not result.converged
        assert result.end_cost > 20


def test_a_condition_in_a_formula_that_jumps_stalls_the_solve(load: Load) -> None:
    model = load(
        "root A { param x: real = 1\n    constraint c { if x > 1 then x + 9 else x - 3 }\n}\n"
    )()
    result = solved(model)
    assert result.status == "stalled"
    assert float(model.x.value) == 1
    assert result.predicted_decrease == pytest.approx(4)
    assert "a further decrease of 4 is predicted (100 % of the cost)" in str(result)


def test_large_constants_that_cancel_end_by_their_noise(load: Load) -> None:
    """The residual is known to 1e-7 only, of which the machine precision says nothing."""
    text = (
        "root A { param x: real = 0.5\n d: real\n e: real\n"
        "    constraint c { [sin(x) + d - e, cos(x)*0.3 + (d - e), x*x] }\n}\n"
    )
    model = load(text)(d=1e9, e=1e9 + 0.3)
    assert solved(model).status == "converged"
    exact = load(text)(d=0.0, e=0.3)
    solved(exact)
    assert float(model.x.value) == pytest.approx(float(exact.x.value), rel=1e-5)


# --- losses -----------------------------------------------------------------------------------


def rho(loss: str, z: Any) -> Any:
    """Losses of a squared residual, at width 1."""
    if loss == "cauchy":
        return np.log1p(z)
    if loss == "huber":
        return np.where(z <= 1, z, 2 * np.sqrt(np.maximum(z, 1)) - 1)
    return (1 - np.maximum(1 - z, 0) ** 3) / 3


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("loss", ["cauchy", "huber", "tukey"])
def test_losses_end_where_no_step_lowers_the_cost(load: Load, precision: str, loss: str) -> None:
    """Scales are random: the units of residuals decide how many are outliers."""
    kind = load(ROBUST.replace("LOSS", f"{loss}(1)"), precision)
    rng = np.random.default_rng(5)
    converged = 0
    for _ in range(25):
        scale = float(np.exp(rng.uniform(-6, 3)))
        x = np.linspace(-1, 1, 15)
        y = 0.7 * x - 0.2 + 0.1 * rng.normal(size=15)
        y[::5] += rng.normal(size=3) * 3
        model = kind(s=scale)
        model.points.extend(x=x, y=y)
        result = solved(model)
        if not result.converged:
            continue
        converged += 1
        end = np.array([float(model.a.value), float(model.b.value)])

        def cost(v, x=x, y=y, scale=scale):
            return float(rho(loss, np.square(scale * (v[0] * x + v[1] - y))).sum())

        now = cost(end)
        assert now == pytest.approx(result.end_cost, rel=1e-9 if precision == "f64" else 1e-4)
        # Iteratively reweighted least squares: a Gauss-Newton step of the loss, at any length.
        r = scale * (end[0] * x + end[1] - y)
        z = r * r
        weight = (rho(loss, z * (1 + 1e-6)) - rho(loss, z * (1 - 1e-6))) / np.maximum(
            2e-6 * z, 1e-300
        )
        design = scale * np.column_stack([x, np.ones_like(x)])
        step = np.linalg.lstsq(
            design * np.sqrt(weight)[:, None], -r * np.sqrt(weight), rcond=1e-12
        )[0]
        best = min(cost(end + length * step) for length in (1, 0.5, 0.25, 0.1, 0.01))
        assert now - best <= (1e-8 if precision == "f64" else 1e-4) * now
    assert converged >= 23


# --- flat regions -----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_saturation_from_a_start_on_its_plateau(load: Load, seed: int) -> None:
    """At b = 1 and x from 1 on, exp(-b x) is all but gone: a step too long leaves it at nothing."""
    rng = np.random.default_rng(seed)
    x = np.array([1.0, 2, 3, 5, 7, 10])
    y = 210 * (1 - np.exp(-0.55 * x)) + 12 * rng.normal(size=6)
    best = least_squares(lambda v: v[0] * (1 - np.exp(-v[1] * x)) - y, [210, 0.55])
    model = load(SATURATION)(a=1.0, b=1.0)
    model.points.extend(x=x, y=y)
    result = solved(model)
    assert result.status == "converged" and result.iterations < 40
    np.testing.assert_allclose([model.a.value, model.b.value], best.x, rtol=1e-4)


@pytest.mark.parametrize("seed", range(6))
def test_two_decays_from_far_away(load: Load, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.arange(0, 330, 10.0)
    truth = np.array([0.375, 1.94, -1.46, 0.0129, 0.0221])

    def curve(v):
        return v[0] + v[1] * np.exp(-v[3] * x) + v[2] * np.exp(-v[4] * x)

    y = curve(truth) + 1e-3 * rng.normal(size=len(x))
    best = least_squares(lambda v: curve(v) - y, truth, xtol=1e-15, ftol=1e-15, x_scale="jac")
    model = load(DECAYS)(a=50.0, b=150.0, c=-100.0, d=1.0, e=2.0)
    model.points.extend(x=x, y=y)
    result = solved(model)
    assert result.status == "converged"
    assert result.end_cost == pytest.approx(2 * best.cost, rel=1e-6)


# --- public data ------------------------------------------------------------------------------


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize("name", held(nist.FORMULAS, "nist/{}.dat"))
def test_certified_values_are_reached_from_both_starts(load: Load, name: str, start: int) -> None:
    values, cost, data = nist.parsed(public(f"nist/{name}.dat").read_text())
    kind = load(nist.model_text(name, len(values)))
    model = nist.filled(kind, values[:, start], data)
    result = solved(model)
    assert result.status == "converged"
    found = [float(getattr(model, f"b{k + 1}").value) for k in range(len(values))]
    # Six certified digits, with default settings.
    np.testing.assert_allclose(found, values[:, 2], rtol=1e-6)
    # The certified cost of Lanczos1 has the rounding of its data.
    assert result.end_cost == pytest.approx(cost, rel=1e-8 if name != "Lanczos1" else 0.01)
