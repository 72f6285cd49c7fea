"""Derivatives against central differences, against models' own, and at singular points."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings

from arael import sym
from arael.calculator.calculator import Calculator
from arael.diagnostics.records import AraelError
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from tests.sym.formulas import NAMES, all_functions, central, of_symbols, points, trees
from tests.symbolic.programs import inputs
from tests.symbolic.programs import jacobian as of_graph


@settings(max_examples=50)
@given(trees(), points())
def test_against_central_differences(text: str, at: list[float]) -> None:
    f = sym.parse(text)
    where = dict(zip(NAMES, at, strict=True))
    scale = 1.0 + abs(sym.eval(f, where))
    for name in NAMES:
        slope = sym.eval(sym.diff(f, name), where)
        assert slope == pytest.approx(central(f, name, where), rel=1e-4, abs=1e-5 * scale)


@settings(max_examples=30)
@given(trees(2), points())
def test_second_derivative_is_the_derivative_of_the_first(text: str, at: list[float]) -> None:
    f = sym.parse(text)
    where = dict(zip(NAMES, at, strict=True))
    first = f.diff("x")
    scale = 1.0 + abs(sym.eval(first, where))
    found = sym.eval(f.diff("x", 2), where)
    assert found == pytest.approx(central(first, "x", where), rel=1e-3, abs=1e-4 * scale)


@pytest.mark.sweep(3)
@pytest.mark.parametrize("name", all_functions())
def test_every_function_against_central_differences(name: str) -> None:
    f = of_symbols(name)
    for point in ((0.31, 0.77, 0.9), (0.85, 0.21, 0.5), (0.52, 0.4, 0.47)):
        at = dict(zip(NAMES, point, strict=True))
        for variable in sym.free_vars(f):
            expected = central(f, variable, at)
            slope = sym.eval(f.diff(sp.Symbol(variable)), at)
            assert slope == pytest.approx(expected, rel=2e-6, abs=2e-6)


SINGULAR = (0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.0, math.pi)
# SymPy's own derivative of a power divides by its base.
BY_SYMPY = {"pow"}


@pytest.mark.sweep(4)
@pytest.mark.parametrize("name", [n for n in all_functions() if n not in BY_SYMPY])
def test_values_and_derivatives_are_those_of_models(name: str) -> None:
    """Also where they are infinite or NaN."""
    f = of_symbols(name)
    arity = SCALARS[name].arity
    g = Graph()
    arguments = inputs(g, arity)
    node = SCALARS[name](g, *arguments)
    slopes = [sym.compiled(f.diff(v), NAMES[:arity]) for v in NAMES[:arity]]
    for i, first in enumerate(SINGULAR):
        for second in SINGULAR if arity > 1 else SINGULAR[:1]:
            point = (first, second, SINGULAR[i - 3])[:arity]
            expected = of_graph(g, [node], arguments, point)[0]
            found = [slope(*point) for slope in slopes]
            np.testing.assert_allclose(found, expected, rtol=1e-12, err_msg=f"{name}{point}")


def test_as_the_reference_shows() -> None:
    x = sym.symbol("x")
    f = sym.sin(x) * x + 1.0
    assert sym.text(f.diff("x")) == "x * cos(x) + sin(x)"
    assert sym.eval(f, {"x": 2.0}) == pytest.approx(2.0 * math.sin(2.0) + 1.0, abs=1e-15)
    assert sym.free_vars(f) == ("x",)


@pytest.mark.parametrize(
    ("text", "derivative"),
    [
        ("x^3 + 2*x^2 - x + 7", "3 * x^2 + 4 * x - 1"),
        ("x^2 * x", "3 * x^2"),
        ("1 / (1 + exp(-x))", "exp(-x) / (1 + exp(-x))^2"),
        ("exp(-x^2 / 2)", "-x * exp(-x^2 / 2)"),
        ("log(x^2 + 1)", "2 * x / (x^2 + 1)"),
        ("sqrt(1 - x^2)", "-x / sqrt(1 - x^2)"),
        ("if x < 0 then -x else x^2", "if x < 0 then -1 else 2 * x"),
        ("y", "0"),
        ("sin(2 * x)", "2 * cos(2 * x)"),
        ("min(x, y)", "if x <= y then 1 else 0"),
        ("floor(x) * x + sign(y - x)", "floor(x)"),
    ],
)
def test_derivatives_read_well(text: str, derivative: str) -> None:
    assert sym.text(sym.parse(text).diff("x")) == derivative


def test_the_arm_not_taken_does_not_leak() -> None:
    f = sym.parse("if x > 0 then sqrt(x) else 3 * x")
    assert sym.eval(f.diff("x"), x=-1.0) == 3.0
    assert sym.eval(f.diff("x"), x=0.0) == 3.0


@settings(max_examples=20)
@given(points(2))
def test_jacobian_and_hessian(at: list[float]) -> None:
    x, y = sym.symbols("x y")
    where = dict(zip("xy", at, strict=True))
    values = sp.Matrix([sp.sin(x * y), sp.exp(x) * y, x**2 + 3])
    found = sym.eval(sym.jacobian(values, [x, "y"]), where)
    assert found.shape == (3, 2)
    for j, name in enumerate("xy"):
        np.testing.assert_allclose(found[:, j], central(values, name, where), atol=1e-7)
    hessian = sym.eval(sym.hessian(values[0]), where)
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-15)
    gradient = sym.gradient(values[0])
    np.testing.assert_allclose(hessian[:, 0], central(gradient, "x", where), atol=1e-7)


def test_of_quaternions_and_transforms() -> None:
    w = sym.vector("w", 3)
    q = sym.exp(w)
    at = {"w.x": 0.3, "w.y": -0.2, "w.z": 0.5}
    for name in at:
        slope = sym.eval(sym.diff(q, name), at)
        np.testing.assert_allclose(slope, central(q, name, at), atol=1e-8)
    moved = sym.diff(sym.transform(w, q), "w.y")
    np.testing.assert_allclose(sym.eval(moved, at)[:3], [0, 1, 0])


@pytest.mark.parametrize("by", ["2x", "", 3, sym.parse("x + 1")])
def test_only_by_variables(by: object) -> None:
    with pytest.raises(AraelError) as caught:
        sym.diff(sym.parse("x"), by)
    assert caught.value.diagnostics[0].code in ("E0651", "E0652")
    with pytest.raises(AraelError, match="E0652"):
        sym.diff(sym.parse("x"), "x", 17)


@pytest.mark.slow
def test_what_is_differentiated_is_bounded() -> None:
    f = sym.symbol("x")
    for _ in range(12):
        f = sp.sin(f) * f
    with pytest.raises(AraelError, match="E0653"):
        sym.diff(f, "x")
    assert f.diff("x").is_Add, "SymPy's own is not"


@pytest.mark.slow
def test_nested_diff_in_a_calculator_is_bounded() -> None:
    text = "sin(x) * x"
    for _ in range(12):
        text = f"sin({text}) * ({text})"
    with pytest.raises(AraelError) as caught:
        list(Calculator().run(f"diff({text}, x)"))
    assert caught.value.diagnostics[0].code == "E0653"


@pytest.mark.parametrize(
    "text", ["clamp(x, (0)/0, 1) * heaviside(y - a)", "min(x, 0/0)", "max(0/0 + 1, x)"]
)
def test_functions_of_nan_have_the_derivative_nan(text: str) -> None:
    assert sym.diff(sym.parse(text), "x") is sp.nan
