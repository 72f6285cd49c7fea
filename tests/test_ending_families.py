"""Families of random problems, over scales of residuals and of parameters, in both precisions.

Each end is judged by an independent computation in doubles. `converged` must mean that SciPy gains
nothing from there on; any other end must come with a predicted decrease above the noise, and may
be no more than a small share of the draws.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from arael.model import Model
from arael.result import Result
from tests.interpreted import Load, loader

PRECISIONS = ("f64", "f32")
SCALES = (1e-8, 1e-4, 1.0, 1e4, 1e8)
DRAWS = 8

# Parameters are in units of `u`, residuals in units of `s`.
CURVE = """
struct Point { x: real
    y: real
    w: real = 1
    constraint fit WHEN LOSS {
        root.s * (root.a/root.u * exp(-root.b/root.u * x) + root.c/root.u - y)
    }
}
root A {
    param a: real
    param b: real
    param c: real
    s: real = 1
    u: real = 1
    points: list of Point
}
"""
PLANE = """
struct Match { p: vec2
    q: vec2
    constraint near LOSS { root.s * (root.t + root.th.rotation_matrix()*p - q) }
}
root A { param t: vec2 = [0, 0]
    param th: angle = 0
    s: real = 1
    matches: list of Match }
"""
LINEAR = """
struct Row { v: vec3
    y: real
    constraint fit { root.s * (dot(v, root.p) - y) }
}
root A { param p: vec3 = [0, 0, 0]
    s: real = 1
    rows: list of Row }
"""
SYSTEM = """
root A { param x: real
    param y: real
    s: real = 1
    u: real = 1
    p: vec2
    constraint c {
        let X = x / u
        let Y = y / u
        s * [X*X + Y*Y - p.x, X - Y*Y*Y - p.y]
    }
}
"""
SUM = """
root A { param x: real = 1
    param y: real = 1
    s: real = 1
    t: real
    constraint c { s * ((x + y)^2 - t) }
}
"""
WINDOW = """
struct Point { x: real
    constraint near when abs(root.m - x) < root.reach { root.s * (root.m - x) }
    constraint far when abs(root.m - x) >= root.reach { root.s * root.reach + 0*root.m }
}
root A { param m: real
    s: real = 1
    reach: real = 1
    points: list of Point }
"""

Residuals = Callable[[Any], Any]


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    """Load a model's text, once each, without compiling it."""
    load = loader(tmp_path_factory.mktemp("families"))

    def model(text: str, precision: str = "f64") -> type[Model]:
        return load(text.replace("WHEN ", "").replace("LOSS ", ""), precision)

    return model


def judged(model: Any, residuals: Residuals, at: Callable[[], Any], precision: str) -> Result:
    """Solve and judge the end; `residuals` are functions of what `at` returns of the model."""
    result: Result = model.solve()
    assert result.end_cost <= result.start_cost
    x = np.asarray(at(), dtype=np.float64)
    first, cost = result.start_cost, float(np.square(residuals(x)).sum())
    double = precision == "f64"
    # Of an exact solution, nothing but the rounding of its terms is left.
    exact = cost <= (1e-24 if double else 1e-10) * first
    if not exact:
        assert cost == pytest.approx(result.end_cost, rel=1e-7 if double else 1e-2)
    if result.status == "converged":
        if not exact:
            found = least_squares(
                residuals, x, method="lm", x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15
            )
            assert cost - 2 * found.cost <= (1e-8 if double else 1e-3) * cost
    else:
        assert result.predicted_decrease > result.noise_floor
    return result


def scalar(model: Any, *names: str) -> Callable[[], Any]:
    """The values of scalar parameters of a root."""
    return lambda: [float(getattr(model, name).value) for name in names]


# --- scales -----------------------------------------------------------------------------------


def curve(rng: Any, exact: bool = False) -> tuple[Any, Any, Any]:
    """Samples of an exponential, and the parameters behind them."""
    x = np.linspace(0, 4, 12)
    true = np.array([rng.uniform(1, 3), rng.uniform(0.3, 1.5), rng.uniform(-1, 1)])
    y = true[0] * np.exp(-true[1] * x) + true[2]
    return x, y + (0 if exact else 0.05) * rng.normal(size=12), true


@pytest.mark.sweep(4)
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("exact", [False, True], ids=["overdetermined", "exact"])
@pytest.mark.parametrize("unit", ["residuals", "parameters"])
@pytest.mark.parametrize("scale", SCALES)
def test_curves_in_any_units(
    load: Load, scale: float, unit: str, exact: bool, precision: str
) -> None:
    kind = load(CURVE, precision)
    s, u = (scale, 1.0) if unit == "residuals" else (1.0, scale)
    for draw in range(DRAWS):
        rng = np.random.default_rng(draw)
        x, y, true = curve(rng, exact)
        start = true * rng.uniform(0.5, 1.5, 3) * u
        model = kind(a=start[0], b=start[1], c=start[2], s=s, u=u)
        model.points.extend(x=x, y=y)
        result = judged(
            model,
            lambda v, x=x, y=y: s * (v[0] / u * np.exp(-v[1] / u * x) + v[2] / u - y),
            scalar(model, "a", "b", "c"),
            precision,
        )
        assert result.status == "converged", draw


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("unit", ["residuals", "parameters"])
@pytest.mark.parametrize("scale", SCALES)
def test_systems_with_a_root(load: Load, scale: float, unit: str, precision: str) -> None:
    kind = load(SYSTEM, precision)
    s, u = (scale, 1.0) if unit == "residuals" else (1.0, scale)
    for draw in range(DRAWS):
        rng = np.random.default_rng(draw)
        true = rng.uniform(0.5, 2, 2)
        p = np.array([np.square(true).sum(), true[0] - true[1] ** 3])
        start = true * rng.uniform(0.7, 1.3, 2) * u
        model = kind(x=start[0], y=start[1], s=s, u=u, p=p)
        result = judged(
            model,
            lambda v, p=p: s * (np.array([np.square(v / u).sum(), v[0] / u - (v[1] / u) ** 3]) - p),
            scalar(model, "x", "y"),
            precision,
        )
        assert result.status == "converged", draw
        assert result.end_cost <= (1e-24 if precision == "f64" else 1e-9) * s * s


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("scale", SCALES)
def test_linear_fits_of_any_conditioning(load: Load, scale: float, precision: str) -> None:
    kind = load(LINEAR, precision)
    for draw in range(DRAWS):
        rng = np.random.default_rng(draw)
        columns = 10.0 ** rng.uniform(-3, 3, 3)  # units of the parameters
        v = rng.normal(size=(9, 3)) * columns
        y = v @ (rng.normal(size=3) / columns) + 0.1 * rng.normal(size=9)
        model = kind(s=scale)
        model.rows.extend(v=v, y=y)
        result = judged(
            model, lambda p, v=v, y=y: scale * (v @ p - y), lambda m=model: m.p.value, precision
        )
        assert result.status == "converged" and result.iterations <= 3
        best = np.linalg.lstsq(v / columns, y, rcond=None)[0]
        np.testing.assert_allclose(
            np.asarray(model.p.value) * columns, best, atol=1e-9 if precision == "f64" else 1e-3
        )


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("scale", SCALES)
def test_a_flat_direction_does_not_keep_the_rest_from_ending(
    load: Load, scale: float, precision: str
) -> None:
    """Only the sum is determined."""
    for t in np.exp(np.random.default_rng(3).uniform(-4, 4, DRAWS)):
        model = load(SUM, precision)(s=scale, t=t)
        assert model.solve().status == "converged"
        total = float(model.x.value) + float(model.y.value)
        assert total == pytest.approx(np.sqrt(t), rel=1e-9 if precision == "f64" else 1e-3)


# --- guards -----------------------------------------------------------------------------------


@pytest.mark.parametrize("precision", PRECISIONS)
def test_guards_over_data_leave_out_what_they_should(load: Load, precision: str) -> None:
    kind = load(CURVE.replace("WHEN", "when w > 0.5"), precision)
    for draw in range(2 * DRAWS):
        rng = np.random.default_rng(draw)
        x, y, true = curve(rng)
        w = np.where(rng.uniform(size=12) < 0.3, 0.0, 1.0)
        y = np.where(w > 0.5, y, 1e3)
        model = kind(**dict(zip("abc", true * 1.2, strict=True)))
        model.points.extend(x=x, y=y, w=w)
        on = w > 0.5
        result = judged(
            model,
            lambda v, x=x[on], y=y[on]: v[0] * np.exp(-v[1] * x) + v[2] - y,
            scalar(model, "a", "b", "c"),
            precision,
        )
        assert result.status == "converged", draw


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_guards_over_parameters_as_a_window(load: Load, scale: float, precision: str) -> None:
    """A mean of what is near: its cost is continuous, and its slope jumps."""
    kind, converged = load(WINDOW, precision), 0
    for draw in range(2 * DRAWS):
        rng = np.random.default_rng(draw)
        x = np.concatenate([0.3 * rng.normal(size=12), rng.uniform(-6, 6, 5)])
        model = kind(m=rng.uniform(-1, 1), s=scale)
        model.points.extend(x=x)
        result = model.solve()
        assert result.end_cost <= result.start_cost
        m = float(model.m.value)
        cost = lambda m, x=x: scale**2 * np.minimum(np.square(m - x), 1).sum()  # noqa: E731
        assert result.end_cost == pytest.approx(cost(m), rel=1e-9 if precision == "f64" else 1e-4)
        if result.status != "converged":
            assert result.predicted_decrease > result.noise_floor
            continue
        converged += 1
        near = abs(m - x) < 1
        assert m == pytest.approx(x[near].mean(), abs=1e-5 if precision == "f64" else 1e-3)
    assert converged >= 2 * DRAWS - 2


# --- losses -----------------------------------------------------------------------------------

LOSSES: dict[str, Callable[[Any], Any]] = {
    "huber(1)": lambda z: np.where(z <= 1, z, 2 * np.sqrt(np.maximum(z, 1)) - 1),
    "cauchy(1)": np.log1p,
    "geman_mcclure(1)": lambda z: z / (1 + z),
    "tukey(1)": lambda z: (1 - np.maximum(1 - z, 0) ** 3) / 3,
    "welsch(1)": lambda z: -np.expm1(-z),
    "fair(1)": lambda z: 2 * (np.sqrt(z) - np.log1p(np.sqrt(z))),
    "|z| 2*(sqrt(1 + z) - 1)": lambda z: 2 * z / (np.sqrt(1 + z) + 1),
}


@pytest.mark.sweep(3)
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("loss", LOSSES)
def test_losses_on_scalars(load: Load, loss: str, precision: str) -> None:
    """Scales are random: the units of residuals decide how many are outliers."""
    kind, rho = load(CURVE.replace("LOSS", f"loss {loss}"), precision), LOSSES[loss]
    converged = 0
    for draw in range(2 * DRAWS):
        rng = np.random.default_rng(draw)
        x, y, true = curve(rng)
        y[::4] += 2 * rng.normal(size=3)
        s = float(np.exp(rng.uniform(-4, 3)))
        model = kind(s=s, **dict(zip("abc", true * rng.uniform(0.8, 1.2, 3), strict=True)))
        model.points.extend(x=x, y=y)

        def residuals(v: Any, x: Any = x, y: Any = y, s: float = s) -> Any:
            r = s * (v[0] * np.exp(-v[1] * x) + v[2] - y)
            return np.sign(r) * np.sqrt(rho(r * r))

        converged += judged(model, residuals, scalar(model, "a", "b", "c"), precision).converged
    assert converged >= 2 * DRAWS - 2


@pytest.mark.sweep(3)
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("loss", LOSSES)
def test_losses_on_several_residuals(load: Load, loss: str, precision: str) -> None:
    kind, rho = load(PLANE.replace("LOSS", f"loss {loss}"), precision), LOSSES[loss]
    converged = 0
    for draw in range(2 * DRAWS):
        rng = np.random.default_rng(draw)
        p = rng.normal(size=(15, 2))
        turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
        q = p @ turn.T + [0.3, -0.2] + 0.05 * rng.normal(size=p.shape)
        q[::4] += 2 * rng.normal(size=(4, 2))
        s = float(np.exp(rng.uniform(-4, 3)))
        model = kind(s=s, t=[0.2, -0.1], th=0.3)
        model.matches.extend(p=p, q=q)

        def residuals(v: Any, p: Any = p, q: Any = q, s: float = s) -> Any:
            c, d = np.cos(v[2]), np.sin(v[2])
            r = s * (v[:2] + p @ np.array([[c, d], [-d, c]]) - q)
            z = np.square(r).sum(axis=1, keepdims=True)
            return (r * np.sqrt(rho(z) / np.maximum(z, 1e-300))).ravel()

        converged += judged(
            model, residuals, lambda m=model: [*m.t.value, float(m.th.value)], precision
        ).converged
    assert converged >= 2 * DRAWS - 2
