"""Derivatives against central differences, against models' own, and at singular points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from arael import sym
from arael.diagnostics.records import AraelError
from arael.sym.calculator import Calculator
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from tests.sym.formulas import NAMES, all_functions, central, of_symbols, points, trees
from tests.symbolic.programs import inputs
from tests.symbolic.programs import jacobian as of_graph


@given(trees(), points())
def test_against_central_differences(text: str, at: list[float]) -> None:
    f = sym.parse(text)
    where = dict(zip(NAMES, at, strict=True))
    scale = 1.0 + abs(f.eval(where))
    for name in NAMES:
        slope = f.diff(name).eval(where)
        assert slope == pytest.approx(central(f, name, where), rel=1e-4, abs=1e-5 * scale)


@given(trees(2), points())
def test_second_derivative_is_the_derivative_of_the_first(text: str, at: list[float]) -> None:
    f = sym.parse(text)
    where = dict(zip(NAMES, at, strict=True))
    first = f.diff("x")
    scale = 1.0 + abs(first.eval(where))
    found = f.diff("x", 2).eval(where)
    assert found == pytest.approx(central(first, "x", where), rel=1e-3, abs=1e-4 * scale)


@pytest.mark.parametrize("name", all_functions())
def test_every_function_against_central_differences(name: str) -> None:
    f = of_symbols(name)
    for point in ((0.31, 0.77, 0.9), (0.85, 0.21, 0.5), (0.52, 0.4, 0.47)):
        at = dict(zip(NAMES, point, strict=True))
        for variable in f.free_vars:
            expected = central(f, variable, at)
            assert f.diff(variable).eval(at) == pytest.approx(expected, rel=2e-6, abs=2e-6)


SINGULAR = (0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.0, math.pi, 1e300, 1e-300)


@pytest.mark.parametrize("name", all_functions())
def test_values_and_derivatives_are_those_of_models(name: str) -> None:
    """Also where they are infinite or NaN."""
    f = of_symbols(name)
    arity = SCALARS[name].arity
    g = Graph()
    arguments = inputs(g, arity)
    node = SCALARS[name](g, *arguments)
    for i, first in enumerate(SINGULAR):
        for second in SINGULAR if arity > 1 else SINGULAR[:1]:
            point = (first, second, SINGULAR[i - 3])[:arity]
            at = dict(zip(NAMES, point, strict=False))
            slopes = of_graph(g, [node], arguments, point)[0]
            for variable, expected in zip(NAMES, slopes, strict=False):
                found = f.diff(variable).eval(at)
                np.testing.assert_allclose(found, expected, rtol=1e-12, err_msg=f"{name}{point}")


def test_as_the_reference_shows() -> None:
    x = sym.symbol("x")
    f = sym.sin(x) * x + 1.0
    assert str(f) == "sin(x) * x + 1"
    assert str(f.diff("x")) == "x * cos(x) + sin(x)"
    assert f.eval({"x": 2.0}) == pytest.approx(2.0 * math.sin(2.0) + 1.0, abs=1e-15)
    assert f.free_vars == ("x",)


@pytest.mark.parametrize(
    ("text", "derivative"),
    [
        ("x^3 + 2*x^2 - x + 7", "3 * x^2 + 4 * x - 1"),
        ("x^2 * x", "3 * x^2"),
        ("1 / (1 + exp(-x))", "exp(-x) / (1 + exp(-x))^2"),
        ("exp(-x^2 / 2)", "-exp(-x^2 / 2) * x"),
        ("log(x^2 + 1)", "2 * x / (x^2 + 1)"),
        ("sqrt(1 - x^2)", "-x / sqrt(1 - x^2)"),
        ("if x < 0 then -x else x^2", "if x < 0 then -1 else 2 * x"),
        ("y", "0"),
        ("sin(2 * x)", "2 * cos(2 * x)"),
    ],
)
def test_derivatives_read_well(text: str, derivative: str) -> None:
    assert str(sym.parse(text).diff("x")) == derivative


def test_the_arm_not_taken_does_not_leak() -> None:
    f = sym.parse("if x > 0 then sqrt(x) else 3 * x")
    assert f.diff("x").eval(x=-1.0) == 3.0
    assert f.diff("x").eval(x=0.0) == 3.0


@given(points(2))
def test_jacobian_and_hessian(at: list[float]) -> None:
    x, y = sym.symbols("x y")
    where = dict(zip("xy", at, strict=True))
    values = sym.Vector([sym.sin(x * y), sym.exp(x) * y, x**2 + 3])
    found = sym.jacobian(values, [x, y]).eval(where)
    assert found.shape == (3, 2)
    for j, name in enumerate("xy"):
        np.testing.assert_allclose(found[:, j], central(values, name, where), atol=1e-7)
    hessian = sym.hessian(values[0]).eval(where)
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-15)
    gradient = sym.gradient(values[0])
    np.testing.assert_allclose(hessian[:, 0], central(gradient, "x", where), atol=1e-7)


@pytest.mark.parametrize("by", ["2x", "", 3, sym.parse("x + 1")])
def test_only_by_variables(by: object) -> None:
    with pytest.raises(AraelError) as caught:
        sym.parse("x").diff(by)  # type: ignore[arg-type]
    assert caught.value.diagnostics[0].code in ("E0651", "E0652")


def test_a_long_sum_is_no_trouble() -> None:
    x = sym.symbol("x")
    f = x
    for i in range(5000):
        f = f + sym.sin(i * x)
    assert f.diff("x").eval(x=0.0) == 1 + sum(range(5000))


def test_derivatives_of_derivatives_are_bounded() -> None:
    f = sym.parse("sqrt(1 + sin(x)^2) * atan(x)")
    with pytest.raises(AraelError) as caught:
        for _ in range(14):
            f = f.diff("x")
    assert caught.value.diagnostics[0].code == "E0653"


def test_nested_diff_in_a_calculator_is_bounded() -> None:
    text = "sqrt(1 + sin(x)^2) * atan(x)"
    for _ in range(14):
        text = f"diff({text}, x)"
    with pytest.raises(AraelError) as caught:
        list(Calculator().run(text))
    assert caught.value.diagnostics[0].code == "E0653"
