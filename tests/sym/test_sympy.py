"""Expressions in SymPy: the same values, and the same derivatives where there is one."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from arael import sym
from arael.diagnostics.records import AraelError

X, Y = sp.symbols("x y", real=True)

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
]
POINTS = [(0.31, 0.77), (-0.63, 0.41), (0.83, -0.57), (-1.27, -0.91)]


@pytest.mark.parametrize("text", FORMULAS)
def test_values_and_derivatives_agree(text: str) -> None:
    ours = sym.parse(text)
    there = sym.to_sympy(ours)
    assert there.free_symbols <= {X, Y}, "something stayed behind as a symbol"
    for x, y in POINTS:
        at = {X: x, Y: y}
        assert float(there.subs(at)) == pytest.approx(ours.eval(x=x, y=y), rel=1e-12, abs=1e-14)
        for by in (X, Y):
            slope = float(sp.diff(there, by).subs(at))
            expected = sym.diff(ours, by.name).eval(x=x, y=y)
            assert slope == pytest.approx(expected, rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("text", FORMULAS)
def test_they_come_back_with_the_same_values(text: str) -> None:
    ours = sym.parse(text)
    back = sym.from_sympy(sym.to_sympy(ours))
    for x, y in POINTS:
        assert back.eval(x=x, y=y) == pytest.approx(ours.eval(x=x, y=y), rel=1e-12, abs=1e-14)


def test_names_of_sympy_are_used() -> None:
    assert sym.to_sympy(sym.parse("max(x, y)")) == sp.Max(X, Y)
    assert sym.to_sympy(sym.parse("log10(x)")) == sp.log(X, 10)
    assert sym.to_sympy(sym.parse("if x < y then x else y")) == sp.Piecewise((X, X < Y), (Y, True))
    assert isinstance(sym.to_sympy(sym.parse("floor(x)")), sp.floor)
    assert sp.diff(sym.to_sympy(sym.parse("floor(x) * x")), X) == sym.to_sympy(
        sym.parse("floor(x)")
    )


def test_lambdify_evaluates_them() -> None:
    there = sym.to_sympy(sym.parse("if x < y then floor(3 * x) else cbrt(x)"))
    found = sp.lambdify([X, Y], there, "numpy")(np.array([0.5, -8.0]), np.array([0.7, -9.0]))
    np.testing.assert_allclose(found, [1.0, -2.0], rtol=1e-15)


def test_a_piecewise_without_a_last_arm_is_refused() -> None:
    with pytest.raises(AraelError, match="E0654"):
        sym.from_sympy(sp.Piecewise((X, X < 0), (1, X < 1)))
    with pytest.raises(AraelError, match="E0654"):
        sym.from_sympy(sp.Heaviside(X, 0))
