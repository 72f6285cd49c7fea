"""Functions of the user: bags, shadowing, derivatives of their own, native ones."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arael import sym
from arael.diagnostics.records import AraelError
from tests.sym.formulas import central


def code_of(error: pytest.ExceptionInfo[AraelError]) -> str:
    return error.value.diagnostics[0].code


def test_a_function_from_python_and_from_text() -> None:
    sigmoid = sym.function("sigmoid(x) = 1 / (1 + exp(-x))")
    x = sym.symbol("x")
    assert str(sigmoid(2 * x)) == "1 / (1 + exp(-2 * x))"
    assert sigmoid(0.0).eval() == 0.5
    bag = sym.FunctionBag("sigmoid(x) = 1 / (1 + exp(-x))")
    assert sym.parse("sigmoid(2 * x)", bag) == sigmoid(2 * x)


def test_the_bag_shadows_built_in_functions() -> None:
    bag = sym.FunctionBag("sin(x) = 10 * x")
    assert sym.parse("sin(2)", bag).eval() == 20.0
    assert sym.parse("sin(2)").eval() == math.sin(2.0)
    bag.define("twice(x) = 2 * sin(x)")
    assert sym.parse("twice(1)", bag).eval() == 20.0


def test_parameters_shadow_outer_names() -> None:
    bag = sym.FunctionBag("f(e) = e + 1", "g(pi, x) = pi * x", "h(y) = x * y")
    assert sym.parse("f(2)", bag).eval() == 3.0
    assert sym.parse("g(2, 3)", bag).eval() == 6.0
    # A name that is no parameter is the variable of that name, whatever the caller calls `x`.
    assert str(sym.parse("h(z)", bag)) == "x * z"
    assert sym.parse("f(x)", bag, {"x": 5.0}).eval() == 6.0
    assert sym.parse("pi + x", names={"pi": 3.0, "x": 1.0}).eval() == 4.0


def test_arguments_are_not_captured() -> None:
    bag = sym.FunctionBag("f(x, y) = x - y", "g(x, y) = f(y, x)")
    assert str(sym.parse("g(y, x)", bag)) == "x - y"
    assert sym.parse("f(f(5, 3), y)", bag).eval(y=1.0) == 1.0


def test_functions_in_any_order() -> None:
    bag = sym.FunctionBag("f(x) = g(x) + 1", "g(x) = x^2")
    assert sym.parse("f(a)", bag).diff("a").eval(a=3.0) == 6.0


def test_derivatives_of_ones_own() -> None:
    bag = sym.FunctionBag("s(x) derivs [s(x) * (1 - s(x))] = 1 / (1 + exp(-x))")
    f = sym.parse("s(2 * a)", bag)
    assert str(f) == "s(2 * a)"
    assert str(f.diff("a")) == "2 * s(2 * a) * (1 - s(2 * a))"
    assert f.diff("a").eval(a=0.3) == pytest.approx(central(f, "a", {"a": 0.3}), rel=1e-8)
    assert f.diff("a", 3).eval(a=0.3) == pytest.approx(
        central(f.diff("a", 2), "a", {"a": 0.3}), rel=1e-6
    )
    wrong = sym.FunctionBag("f(x) derivs [42] = x^2")
    assert sym.parse("f(x) + x", wrong).diff("x").eval(x=1.0) == 43.0


def test_native_functions() -> None:
    calls = []

    def my_asin(x: float) -> float:
        calls.append(x)
        return math.asin(min(max(x, -1.0), 1.0))

    bag = sym.FunctionBag()
    bag.native("my_asin", my_asin, ["x"], ["1 / sqrt(identity(1 - x * x) + 1e-12)"])
    f = sym.parse("2 * my_asin(x / 2) + my_asin(my_asin(x))", bag)
    assert f.eval(x=0.5) == pytest.approx(2 * math.asin(0.25) + math.asin(math.asin(0.5)))
    assert f.diff("x").eval(x=0.5) == pytest.approx(central(f, "x", {"x": 0.5}), rel=1e-6)
    assert np.allclose(f.eval(x=np.array([0.1, 0.5])), [f.eval(x=0.1), f.eval(x=0.5)])
    assert all(type(x) in (float, np.float64) for x in calls)
    assert f.c() == "2.0 * my_asin(x * 0.5) + my_asin(my_asin(x))"
    assert bag["my_asin"](3.0).eval() == math.pi / 2
    assert bag["my_asin"](1.0).args[0].value == 1.0


def test_mutual_recursion_through_derivatives() -> None:
    bag = sym.FunctionBag()
    bag.native("sn", math.sin, ["x"], ["cs(x)"])
    bag.native("cs", math.cos, ["x"], ["-sn(x)"])
    f = sym.parse("sn(3 * x)", bag)
    assert f.diff("x", 4).eval(x=0.2) == pytest.approx(81 * math.sin(0.6))


def test_functions_of_vectors() -> None:
    bag = sym.FunctionBag("half(v) = 0.5 * v", "along(u, v) = dot(u, v) / norm(v)")
    v = sym.Vector("v", 3)
    assert sym.parse("half(p)", bag, {"p": v}) == 0.5 * v
    assert sym.parse("along([1, 2], [3, 4])", bag).eval() == pytest.approx(11 / 5)


def test_functions_of_a_model(tmp_path: Path) -> None:
    text = "fn square(x) = x * x\nextern fn up(x) derivs [1] \nstruct S { x: real }\n"
    bag = sym.FunctionBag.from_model(text, natives={"up": lambda x: x + 1})
    assert sym.parse("square(up(a))", bag).eval(a=2.0) == 9.0
    path = tmp_path / "m.arael"
    path.write_text("fn cube(x) = x^3\n", encoding="utf-8")
    assert list(sym.FunctionBag.from_model(path)) == ["cube"]
    with pytest.raises(AraelError) as caught:
        sym.FunctionBag.from_model(text)
    assert code_of(caught) == "E0651"


@pytest.mark.parametrize(
    ("definition", "code"),
    [
        ("f(x, x) = x", "E0651"),
        ("f(x) derivs [1, 2] = x", "E0651"),
        ("f(x) = ", None),
        ("f(x) = x; g(x) = x", None),
        ("3", None),
        ("f(x) derivs [[1, 2]] = x", "E0652"),
        ("f(x) = f(x)", "E0605"),
        ("f(x) derivs [1] = f(x)", "E0605"),
        ("f(x) = g(x)", "E0205"),
        ("f(x, y) = x", "E0303"),
        ("f(x) = import", None),
    ],
)
def test_wrong_definitions(definition: str, code: str | None) -> None:
    with pytest.raises(AraelError) as caught:
        f = sym.FunctionBag(definition)["f"](sym.symbol("x"))
        f.diff("x").eval(x=1.0)
        f.eval(x=1.0)
    assert code is None or code_of(caught) == code
    assert all(d.span is not None or d.origin for d in caught.value.diagnostics)
