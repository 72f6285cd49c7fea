"""Every scalar function: value, derivative, documented singular points."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
import sympy as sp

from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from tests.symbolic.programs import central, inputs, jacobian, run

LANGUAGE = [
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp"),
    *("log", "log2", "log10", "sqrt", "cbrt", "hypot", "abs", "sign", "min", "max", "clamp"),
    *("floor", "ceil", "round", "heaviside", "pow", "pi", "e", "epsilon", "identity"),
    *("safe_sqrt", "safe_asin", "safe_acos", "safe_atan2", "rad_diff", "rad_sum", "deg2rad"),
    *("erf", "erfc", "expm1", "log1p", "lgamma", "digamma", "sinc"),
    *("rad2deg", "fast_atan", "fast_atan2", "starship", "starship_gamma"),
]

x, y, z = sp.symbols("x y z", real=True)

# An independent definition of each smooth function, differentiated by SymPy.
SMOOTH = {
    "sin": sp.sin(x), "cos": sp.cos(x), "tan": sp.tan(x), "asin": sp.asin(x), "acos": sp.acos(x),
    "atan": sp.atan(x), "atan2": sp.atan2(x, y), "sinh": sp.sinh(x), "cosh": sp.cosh(x),
    "tanh": sp.tanh(x), "exp": sp.exp(x), "log": sp.log(x), "log2": sp.log(x) / sp.log(2),
    "log10": sp.log(x) / sp.log(10), "sqrt": sp.sqrt(x), "cbrt": x ** sp.Rational(1, 3),
    "hypot": sp.sqrt(x**2 + y**2), "pow": x**y, "identity": x,
    "safe_sqrt": sp.sqrt(x), "safe_asin": sp.asin(x), "safe_acos": sp.acos(x),
    "safe_atan2": sp.atan2(x, y), "fast_atan": sp.atan(x), "fast_atan2": sp.atan2(x, y),
    "rad_diff": x - y, "rad_sum": x + y, "deg2rad": x * sp.pi / 180, "rad2deg": x * 180 / sp.pi,
    "starship": y * sp.atan(x / y), "starship_gamma": 2 * sp.sqrt(x) / sp.pi,
    "abs": sp.Abs(x), "min": sp.Min(x, y), "max": sp.Max(x, y), "pi": sp.pi, "e": sp.E,
}  # fmt: skip
POINTS = [(0.2, 0.7), (0.9, 0.35), (0.51, 1.3), (0.05, 0.06)]


def evaluate(name: str, *point: float) -> tuple[float, list[float]]:
    """Value and partial derivatives."""
    g = Graph()
    arguments = inputs(g, len(point))
    node = SCALARS[name](g, *arguments)
    slopes = jacobian(g, [node], arguments, point)[0]
    return float(run(g, [node], point)[0]), [float(s) for s in slopes]


def test_every_function_of_the_language_is_there() -> None:
    assert sorted(SCALARS) == sorted(LANGUAGE)


@pytest.mark.sweep(slow=("rad2deg",))
@pytest.mark.parametrize("name", SMOOTH)
def test_value_and_derivative_against_sympy(name: str) -> None:
    arguments = (x, y)[: SCALARS[name].arity]
    slopes = [sp.diff(SMOOTH[name], a) for a in arguments]
    tolerance = 6e-8 if name.startswith("fast_") else 0.0
    for point in POINTS:
        at = dict(zip(arguments, point, strict=False))
        value, found = evaluate(name, *point[: len(arguments)])
        expected = float(SMOOTH[name].subs(at).evalf(30))
        assert value == pytest.approx(expected, rel=1e-13, abs=tolerance)
        derivative = [float(s.subs(at).evalf(30)) for s in slopes]
        # The regularisation of the safe functions is below 1e-10 at these points.
        assert found == pytest.approx(derivative, rel=1e-9 if "safe" in name else 1e-13)


@pytest.mark.parametrize("name", [n for n in LANGUAGE if SCALARS[n].arity])
def test_derivative_against_central_differences(name: str) -> None:
    arity = SCALARS[name].arity
    g = Graph()
    arguments = inputs(g, arity)
    node = SCALARS[name](g, *arguments)
    for point in ((0.31, 0.77, 0.9), (0.85, 0.21, 0.5), (0.52, 0.4, 0.47)):
        found = jacobian(g, [node], arguments, point[:arity])
        expected = central(g, [node], point[:arity])
        np.testing.assert_allclose(found, expected, rtol=2e-6, atol=2e-6)


PI = math.pi
INF = math.inf
NAN = math.nan

SINGULAR: list[tuple[str, tuple[float, ...], float, list[float]]] = [
    ("sqrt", (0,), 0, [INF]),
    ("sqrt", (-1,), NAN, [NAN]),
    ("cbrt", (0,), 0, [INF]),
    ("cbrt", (-8,), -2, [1 / 12]),
    ("log", (0,), -INF, [INF]),
    ("log", (-1,), NAN, [-1]),
    ("asin", (1,), PI / 2, [INF]),
    ("acos", (1,), 0, [-INF]),
    ("asin", (1.5,), NAN, [NAN]),
    ("atan2", (0, 0), 0, [NAN, NAN]),
    ("hypot", (0, 0), 0, [NAN, NAN]),
    ("pow", (0, 2), 0, [0, 0]),
    ("pow", (0, 0), 1, [NAN, 0]),
    ("pow", (-2, 3), -8, [12, NAN]),
    ("abs", (0,), 0, [0]),
    ("sign", (0,), 0, [0]),
    ("sign", (-3,), -1, [0]),
    ("heaviside", (0,), 0.5, [0]),
    ("heaviside", (1e-300,), 1, [0]),
    ("heaviside", (-1e-300,), 0, [0]),
    ("floor", (2,), 2, [0]),
    ("floor", (-0.5,), -1, [0]),
    ("ceil", (2,), 2, [0]),
    ("ceil", (2.1,), 3, [0]),
    ("round", (0.5,), 1, [0]),
    ("round", (-0.5,), -1, [0]),
    ("round", (2.5,), 3, [0]),
    ("min", (1, 1), 1, [1, 0]),
    ("max", (1, 1), 1, [1, 0]),
    ("min", (2, 1), 1, [0, 1]),
    ("max", (2, 1), 2, [1, 0]),
    ("clamp", (0, 0, 1), 0, [1, 0, 0]),
    ("clamp", (1, 0, 1), 1, [1, 0, 0]),
    ("clamp", (-1, 0, 1), 0, [0, 1, 0]),
    ("clamp", (2, 0, 1), 1, [0, 0, 1]),
    ("clamp", (1, 2, 0), 0, [0, 0, 1]),
    ("safe_sqrt", (0,), 0, [5e5]),
    ("safe_sqrt", (-1,), 0, [0]),
    ("safe_asin", (1,), PI / 2, [1e6]),
    ("safe_asin", (-1,), -PI / 2, [1e6]),
    ("safe_asin", (1.5,), PI / 2, [0]),
    ("safe_asin", (-7,), -PI / 2, [0]),
    ("safe_acos", (1,), 0, [-1e6]),
    ("safe_acos", (-1,), PI, [-1e6]),
    ("safe_acos", (1.5,), 0, [0]),
    ("safe_acos", (-2,), PI, [0]),
    ("safe_atan2", (0, 0), 0, [0, 0]),
    ("safe_atan2", (0, -1), PI, [-1, 0]),
    ("safe_atan2", (1e-6, 0), PI / 2, [0, -5e5]),
    ("rad_diff", (PI, 0), PI, [1, -1]),
    ("rad_diff", (0, PI), PI, [1, -1]),
    ("rad_sum", (PI, 0), PI, [1, 1]),
    ("rad_sum", (-PI, 0), PI, [1, 1]),
    ("fast_atan", (0,), 0, [1]),
    ("fast_atan2", (0, 0), 0, [NAN, NAN]),
    ("starship", (0, 2), 0, [1, 0]),
    ("starship", (1, 0), 0, [0, NAN]),
    ("starship_gamma", (0,), 0, [INF]),
    ("starship_gamma", (25,), 10 / PI, [1 / (5 * PI)]),
]


@pytest.mark.parametrize(("name", "point", "value", "slopes"), SINGULAR)
def test_singular_point(
    name: str, point: tuple[float, ...], value: float, slopes: list[float]
) -> None:
    found_value, found_slopes = evaluate(name, *point)
    assert found_value == pytest.approx(value, rel=1e-12, nan_ok=True)
    assert found_slopes == pytest.approx(slopes, rel=1e-9, nan_ok=True)


FINITE = ["safe_sqrt", "safe_asin", "safe_acos", "safe_atan2", "heaviside", "sign", "clamp",
          "floor", "ceil", "round", "rad_diff", "rad_sum", "abs", "min", "max"]  # fmt: skip


@pytest.mark.sweep(3)
@pytest.mark.parametrize("name", FINITE)
def test_finite_in_value_and_derivative_everywhere(name: str) -> None:
    grid = [0.0, 1e-300, 1e-12, 0.5, 1.0 - 1e-16, 1.0, 1.0 + 1e-15, PI, 1e6, 1e150]
    grid += [-v for v in grid]
    for first in grid:
        for second in grid if SCALARS[name].arity > 1 else [0.0]:
            value, slopes = evaluate(name, *(first, second, 0.25)[: SCALARS[name].arity])
            assert np.isfinite([value, *slopes]).all(), (first, second)


@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 2])
def test_wrapped_angles_stay_in_the_half_open_interval(turns: int) -> None:
    for angle in np.linspace(-PI + 1e-9, PI, 41):
        value, _ = evaluate("rad_diff", angle + 2 * PI * turns, 0.0)
        assert value == pytest.approx(angle, abs=1e-12) or (
            abs(angle) > PI - 1e-6 and abs(abs(value) - PI) < 1e-8
        )
        assert -PI - 1e-12 < value <= PI + 1e-12


def test_small_angle_differences_are_exact() -> None:
    assert evaluate("rad_diff", 0.3, 0.1)[0] == 0.3 - 0.1


def test_stated_errors_of_the_fast_arc_tangents() -> None:
    t = np.concatenate([np.linspace(-1.5, 1.5, 30001), np.geomspace(1.0, 1e8, 2001)])
    g = Graph()
    (a,) = inputs(g, 1)
    fast = run(g, [SCALARS["fast_atan"](g, a)], [t])[0]
    assert np.max(np.abs(fast - np.arctan(t))) < 6e-8
    angle = np.linspace(-PI + 1e-9, PI - 1e-9, 40001)
    g = Graph()
    a, b = inputs(g, 2)
    fast = run(g, [SCALARS["fast_atan2"](g, a, b)], [np.sin(angle), np.cos(angle)])[0]
    assert np.max(np.abs(fast - angle)) < 6e-8


def test_constants() -> None:
    assert evaluate("pi")[0] == float(mpmath.pi)
    assert evaluate("e")[0] == float(mpmath.e)
    assert evaluate("epsilon")[0] == np.finfo(float).eps


def test_starship_bounds_the_cost() -> None:
    gamma = evaluate("starship_gamma", 25.0)[0]
    assert evaluate("starship", 1e12, gamma)[0] ** 2 == pytest.approx(25.0, rel=1e-9)


def test_wrong_number_of_arguments() -> None:
    g = Graph()
    with pytest.raises(ValueError, match="clamp takes 3 arguments, not 1"):
        SCALARS["clamp"](g, g.const(1.0))
