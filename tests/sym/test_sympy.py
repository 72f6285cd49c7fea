"""What SymPy does with formulas, and the language's functions by SymPy's own."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import sympy as sp

from arael import sym
from arael.diagnostics.records import AraelError

X, Y = sp.symbols("x y")

FORMULAS = [
    "max(x, y) * min(x^2, 1 + y)",
    "floor(3 * x) + ceil(x * y) + round(2 * x) * x",
    "x * sign(x) + y * heaviside(x - 0.2)",
    "cbrt(x) + cbrt(x * y - 2)",
    "log10(2 + x) + log2(3 + y)",
    "if x < y then x^2 else y * x",
    "if x < 0 and y > 0 or not (x == y) then sin(x) else cos(y)",
    "if x <= 0.1 then 1 else if y >= 0 then x else x * y",
    "clamp(x, -0.5, 0.5) + hypot(x, y)",
    "safe_sqrt(x) + safe_asin(0.3 * x) + safe_acos(0.2 * y) + safe_atan2(y, x)",
    "safe_asin(3 * x) + safe_acos(3 * y) + safe_sqrt(x - y)",
    "starship(x, 0.7) + starship_gamma(2 + x)",
    "deg2rad(x) + rad2deg(y) + epsilon * x",
    "identity(x * y) + abs(x - y)",
    "safe_sqrt(safe_sqrt(abs(x)) + clamp(y, 0, 1))",
    "rad_diff(x, 7 * y) + rad_sum(5, x) + fast_atan2(x, y) + fast_atan(y)",
    "erf(x) + expm1(y) + log1p(x * x) + lgamma(y + 2) + sinc(x)",
]
POINTS = [(0.31, 0.77), (-0.63, 0.41), (0.83, -0.57), (-1.27, -0.91)]


def test_formulas_are_sympys() -> None:
    a, b, c, x = sp.symbols("a b c x")
    f = sym.parse("a * exp(-b * x) + c")
    assert f == a * sp.exp(-b * x) + c
    assert f.diff("b") == -a * x * sp.exp(-b * x)
    assert sp.latex(f) == r"a e^{- b x} + c"
    assert sp.lambdify([a, b, c, x], f)(2, 0, 1, 5) == 3
    assert sym.parse("skew([x, y, z])") == sp.Matrix(
        [[0, -sp.Symbol("z"), Y], [sp.Symbol("z"), 0, -X], [-Y, X, 0]]
    )
    assert sym.parse("x < y") == sp.Lt(X, Y)
    assert sym.parse("if x < y then x else y") == sp.Piecewise((X, X < Y), (Y, True))
    assert isinstance(sym.exp([X, Y, 1]), sp.Quaternion)
    assert sp.solve(sym.parse("x^2 - y"), "y") == [X**2]


def test_numbers_are_exact_where_they_are_short() -> None:
    assert sym.parse("x / 3 + 0.5") == X / 3 + sp.Rational(1, 2)
    assert sym.parse("0.1 * x").args[0] == sp.Float(0.1)
    assert sym.parse("2 ^ 100").is_Float, "it would be long"
    assert sym.parse("sqrt(-1) * x") is sp.nan


@pytest.mark.sweep(3)
@pytest.mark.parametrize("text", FORMULAS)
def test_values_and_derivatives_agree_with_sympys_own(text: str) -> None:
    ours = sym.parse(text)
    there = sym.to_sympy(ours)
    assert not any(hasattr(part, "_imp_") for part in sp.preorder_traversal(there))
    real = {X: sp.Symbol("x", real=True), Y: sp.Symbol("y", real=True)}
    for x, y in POINTS:
        at = {"x": x, "y": y}
        value = sym.eval(ours, at)
        close = 2e-7 if "fast" in text else 1e-14
        assert sym.eval(there, at) == pytest.approx(value, rel=1e-12, abs=close)
        assert float(ours.subs(at)) == pytest.approx(value, rel=1e-12, abs=1e-14)
        # SymPy leaves the derivatives of `floor` and `ceiling` as they are.
        for by in () if "floor" in text or "rad_diff" in text else (X, Y):
            slope = sp.diff(there.xreplace(real), real[by]).subs({real[X]: x, real[Y]: y})
            expected = sym.eval(ours.diff(by), at)
            assert float(slope) == pytest.approx(expected, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("text", FORMULAS)
def test_lambdify_evaluates_them(text: str) -> None:
    f = sym.parse(text)
    x, y = np.array(POINTS).T
    with np.errstate(all="ignore"):
        found = sp.lambdify([X, Y], f, ["numpy", "scipy"])(x, y)
    np.testing.assert_allclose(found, sym.eval(f, x=x, y=y), rtol=1e-12, atol=1e-14)


def test_to_sympy_and_back() -> None:
    assert sym.to_sympy(sym.parse("max(x, y)")) == sp.Max(X, Y)
    assert sym.to_sympy(sym.parse("log10(x)")) == sp.log(X, 10)
    there = sp.Abs(X) + sp.Max(X, Y, 2) - sp.ceiling(X)
    back = sym.from_sympy(there)
    assert sym.text(back) == "abs(x) - ceil(x) + max(max(2, x), y)"
    assert sym.eval(back.diff("x"), x=-3.0, y=0.0) == -1.0
    assert sym.eval(there, x=-3.5, y=0.0) == sym.eval(back, x=-3.5, y=0.0) == 8.5


def test_what_sympy_makes_can_be_evaluated() -> None:
    for made in (
        sp.exp(-X / 3),
        sp.Abs(X),
        sp.log(X, 2),
        sp.Max(X, 1),
        sp.pi * X,
        sp.Heaviside(X),
        sp.cot(X),
        sp.ITE(X > 0, X < 1, X < 2),
    ):
        expected = made.subs(X, 0.7)
        found = sym.eval(made, x=0.7)
        assert found == pytest.approx(float(expected)) if expected.is_number else found is True


@pytest.mark.parametrize(
    "made", [sp.zeta(X), sp.Piecewise((X, X < 0), (1, X < 1)), sp.Heaviside(X, 0), sp.Integral(X)]
)
def test_what_the_language_lacks_is_refused(made: sp.Expr) -> None:
    with pytest.raises(AraelError, match="E0654"):
        sym.eval(made, x=0.5)


def test_pickled() -> None:
    f = sym.parse("starship(x, 2) + clamp(x, y, 1) * abs(x)")
    assert pickle.loads(pickle.dumps(f)) == f
