"""Functions of the user: bags, shadowing, derivatives of their own, native ones."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from arael import sym
from arael.diagnostics.records import AraelError
from tests.sym.formulas import central


def code_of(error: pytest.ExceptionInfo[AraelError]) -> str:
    return error.value.diagnostics[0].code


def test_a_function_from_python_and_from_text() -> None:
    sigmoid = sym.function("sigmoid(x) = 1 / (1 + exp(-x))")
    x = sym.symbol("x")
    assert sigmoid(2 * x) == 1 / (1 + sp.exp(-2 * x))
    assert sigmoid(0.0) == sp.Rational(1, 2)
    bag = sym.FunctionBag("sigmoid(x) = 1 / (1 + exp(-x))")
    assert sym.parse("sigmoid(2 * x)", bag) == sigmoid(2 * x)


def test_the_bag_shadows_built_in_functions() -> None:
    bag = sym.FunctionBag("sin(x) = 10 * x")
    assert sym.parse("sin(2)", bag) == 20
    assert sym.eval(sym.parse("sin(2)")) == math.sin(2.0)
    bag.define("twice(x) = 2 * sin(x)")
    assert sym.parse("twice(1)", bag) == 20


def test_parameters_shadow_outer_names() -> None:
    bag = sym.FunctionBag("f(e) = e + 1", "g(pi, x) = pi * x", "h(y) = x * y")
    assert sym.parse("f(2)", bag) == 3
    assert sym.parse("g(2, 3)", bag) == 6
    # A name that is no parameter is the variable of that name, whatever the caller calls `x`.
    assert sym.text(sym.parse("h(z)", bag)) == "x * z"
    assert sym.parse("f(x)", bag, {"x": 5.0}) == 6
    assert sym.parse("pi + x", names={"pi": 3.0, "x": 1.0}) == 4


def test_arguments_are_not_captured() -> None:
    bag = sym.FunctionBag("f(x, y) = x - y", "g(x, y) = f(y, x)")
    assert sym.text(sym.parse("g(y, x)", bag)) == "x - y"
    assert sym.eval(sym.parse("f(f(5, 3), y)", bag), y=1.0) == 1.0


def test_functions_in_any_order() -> None:
    bag = sym.FunctionBag("f(x) = g(x) + 1", "g(x) = x^2")
    assert sym.parse("f(a)", bag).diff("a").subs("a", 3) == 6


def test_derivatives_of_ones_own() -> None:
    bag = sym.FunctionBag("s(x) derivs [s(x) * (1 - s(x))] = 1 / (1 + exp(-x))")
    f = sym.parse("s(2 * a)", bag)
    assert isinstance(f, sp.Function)
    assert sym.text(f) == "s(2 * a)"
    assert sym.text(f.diff("a")) == "2 * (1 - s(2 * a)) * s(2 * a)"
    assert sym.eval(f.diff("a"), a=0.3) == pytest.approx(central(f, "a", {"a": 0.3}), rel=1e-8)
    assert sym.eval(f.diff("a", 3), a=0.3) == pytest.approx(
        central(f.diff("a", 2), "a", {"a": 0.3}), rel=1e-6
    )
    assert float(f.subs("a", 0.3)) == pytest.approx(1 / (1 + math.exp(-0.6)), rel=1e-15)
    wrong = sym.FunctionBag("f(x) derivs [42] = x^2")
    assert sym.parse("f(x) + x", wrong).diff("x") == 43


def test_native_functions() -> None:
    calls = []

    def my_asin(x: float) -> float:
        calls.append(x)
        return math.asin(min(max(x, -1.0), 1.0))

    bag = sym.FunctionBag()
    bag.native("my_asin", my_asin, ["x"], ["1 / sqrt(identity(1 - x * x) + 1e-12)"])
    f = sym.parse("2 * my_asin(x / 2) + my_asin(my_asin(x))", bag)
    assert not calls, "reading calls nothing"
    assert sym.eval(f, x=0.5) == pytest.approx(2 * math.asin(0.25) + math.asin(math.asin(0.5)))
    assert sym.eval(f.diff("x"), x=0.5) == pytest.approx(central(f, "x", {"x": 0.5}), rel=1e-6)
    each = [sym.eval(f, x=0.1), sym.eval(f, x=0.5)]
    assert np.allclose(sym.eval(f, x=np.array([0.1, 0.5])), each)
    assert np.allclose(sp.lambdify("x", f, "numpy")(np.array([0.1, 0.5])), each)
    assert all(type(x) in (float, np.float64) for x in calls)
    assert sym.c(f) == "my_asin(x * 0.5) * 2.0 + my_asin(my_asin(x))"
    assert float(bag["my_asin"](3.0)) == math.pi / 2
    assert bag["my_asin"](1.0).args == (1,)


def test_mutual_recursion_through_derivatives() -> None:
    bag = sym.FunctionBag()
    bag.native("sn", math.sin, ["x"], ["cs(x)"])
    bag.native("cs", math.cos, ["x"], ["-sn(x)"])
    f = sym.parse("sn(3 * x)", bag)
    assert sym.eval(f.diff("x", 4), x=0.2) == pytest.approx(81 * math.sin(0.6))


def test_functions_of_vectors() -> None:
    bag = sym.FunctionBag("half(v) = 0.5 * v", "along(u, v) = dot(u, v) / norm(v)")
    v = sym.vector("v", 3)
    assert sym.parse("half(p)", bag, {"p": v}) == v / 2
    assert sym.eval(sym.parse("along([1, 2], [3, 4])", bag)) == pytest.approx(11 / 5)


def test_functions_of_a_model(tmp_path: Path) -> None:
    text = "fn square(x) = x * x\nextern fn up(x) derivs [1] \nstruct S { x: real }\n"
    bag = sym.FunctionBag.from_model(text, natives={"up": lambda x: x + 1})
    assert sym.eval(sym.parse("square(up(a))", bag), a=2.0) == 9.0
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
        f.diff("x")
    assert code is None or code_of(caught) == code
    assert all(d.span is not None or d.origin for d in caught.value.diagnostics)
