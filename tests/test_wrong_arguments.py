"""Public functions called from Python with arguments of wrong types: no exception but arael's own.

Each function is called with every argument replaced by each of `WRONG` in turn. What fails must be
an `AraelError`, and must leave a model as it was; that many of the values are also accepted (a
number for an array, a text for a name) is not the point here. Subscripts and attributes follow
Python's protocols (IndexError, KeyError, AttributeError) and are left out.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import arael
from arael import geometry, sym
from arael.diagnostics.records import AraelError

WRONG: list[Any] = [
    None,
    3,
    -1,
    2.5,
    math.nan,
    "ab",
    "",
    b"x",
    [],
    [1, "a"],
    [[1], [2, 3]],
    {"a": None},
    {3: 4},
    (1,),
    object(),
    np.array(["a"]),
    np.zeros((2, 2, 2)),
    sp.Symbol("q"),
    1j,
    int,
    range(3),
]

TEXT = """
struct Thing {
    param a: real = 1
    param p: vec3 = [0, 0, 0]
    x: real = 1
    constraint prior { (a - x) / 0.1 }
    constraint middle { [p.x - 1, p.y, p.z] }
}
struct Point { x: real; y: real }
root M {
    things: list of Thing
    queue:  deque of Thing
    points: list of Point
    param b: real = 0
    s: real = 1
    fit points as d { (b * d.x - d.y) / s }
}
"""

M = arael.loads(TEXT, name="wrong_arguments.arael", interpret=True)


def model() -> Any:
    made = M()
    made.things.extend(2)
    made.queue.extend(3)
    made.points.extend(x=[1, 2, 3], y=[1, 2, 3.1])
    return made


X, Y = sym.symbols("x y")
F = X**2 * Y + sym.sin(X)
DATA = {"x": [0, 1, 2, 3, 4.0], "y": [2.0, 1.2, 0.8, 0.4, 0.3], "g": [0, 0, 1, 1, 1]}
CURVE = "y = a * exp(-b * x)"
KEEP = model()
RUNTIME = KEEP.residuals.add("b - k", label="r", data={"k": 1.0})
KEEP.solve()
COVARIANCE, JACOBIAN, TANGENT = KEEP.covariance(), KEEP.jacobian(), KEEP.problem()
ZERO = np.zeros(TANGENT.size)
BAG = sym.FunctionBag()

SYM: dict[str, tuple[Callable[..., Any], list[Any]]] = {
    "parse": (sym.parse, ["a * x", None, None]),
    "function": (sym.function, ["f(x) = x"]),
    "FunctionBag": (sym.FunctionBag, ["f(x) = x"]),
    "native": (BAG.native, ["f", math.sin, ["x"], ["cos(x)"]]),
    "from_model": (sym.FunctionBag.from_model, ["fn f(x) = x\n", None]),
    "call": (sym.function("f(x) = x^2"), [2.0]),
    "evaluate": (sym.function("f(x) = x^2").evaluate, [2.0]),
    "c": (sym.c, [F, "double"]),
    "c_function": (sym.c_function, ["f", F, None]),
    "latex": (sym.latex, [F]),
    "python": (sym.python, [F]),
    "text": (sym.text, [F]),
    "text of a transform": (lambda a, b: sym.text(sym.Transform(a, b)), [F, F]),
    "diff": (sym.diff, [F, X, 1]),
    "jacobian": (sym.jacobian, [[F], [X]]),
    "gradient": (sym.gradient, [F, [X]]),
    "hessian": (sym.hessian, [F, [X]]),
    "subs": (sym.subs, [F, {X: 1}]),
    "subs by name": (lambda a: sym.subs(F, x=a), [1]),
    "cse": (sym.cse, [[F], "t"]),
    "expand": (sym.expand, [F]),
    "collect": (sym.collect, [F, X]),
    "simplify": (sym.simplify, [F]),
    "eval": (sym.eval, [F, {X: 1, Y: 2}]),
    "eval by name": (lambda a, b: sym.eval(F, x=a, y=b), [1, 2]),
    "compiled": (sym.compiled, [F, [X, Y]]),
    "compiled call": (sym.compiled(F), [1, 2]),
    "free_vars": (sym.free_vars, [F]),
    "from_sympy": (sym.from_sympy, [F]),
    "to_sympy": (sym.to_sympy, [F]),
    "symbol": (sym.symbol, ["x"]),
    "symbols": (sym.symbols, ["x y"]),
    "vector": (sym.vector, ["p", 3]),
    "quaternion": (sym.quaternion, ["q"]),
    "sin": (sym.sin, [X]),
    "atan2": (sym.atan2, [X, Y]),
    "norm": (sym.norm, [sym.vector("p", 3)]),
}

MODELS: dict[str, tuple[Callable[..., Any], list[Any]]] = {
    "load root": (lambda a: arael.load("linear", root=a, interpret=True), [None]),
    "load precision": (lambda a: arael.load("linear", precision=a, interpret=True), [None]),
    "load interpret": (lambda a: arael.load("linear", interpret=a), [True]),
    "loads name": (lambda a: arael.loads(TEXT, name=a, interpret=True), ["m"]),
    "loads text": (arael.loads, [TEXT]),
    "read": (arael.read, [KEEP, "none.json", None]),
    "read collection": (lambda a: arael.read(KEEP, "none.csv", collection=a), [None]),
    "write": (arael.write, [KEEP, "out.json", "json"]),
    "write collection": (lambda a: arael.write(KEEP, "out.csv", collection=a), ["points"]),
    "initialise": (arael.initialise, [KEEP, "auto"]),
    "solve": (lambda a, b, c: model().solve(a, b, c), [None, "auto", None]),
    "solve freeze": (lambda a: model().solve(freeze=a), ["things.a"]),
    "solve trace": (lambda a: model().solve(trace=a), [lambda line: None]),
    "solve progress": (lambda a: model().solve(progress=a), [None]),
    "solver_options": (lambda a: model().solve(solver_options=a), [None]),
    "deserialize": (KEEP.deserialize, [KEEP.serialize()]),
    "hessian_block": (KEEP.hessian_block, [KEEP.things[0], KEEP.things[0]]),
    "residual_values": (KEEP.residual_values, ["Thing.prior"]),
    "covariance": (KEEP.covariance, ["known"]),
    "report": (KEEP.report, ["known"]),
    "profile": (KEEP.profile, ["b", 0.95, "known"]),
    "construct": (lambda a, b: M(things=a, b=b), [[], 1.0]),
    "set root field": (lambda a: setattr(model(), "s", a), [1.0]),
    "read item": (lambda a: KEEP[a], ["b"]),
    "set item": (lambda a: model().__setitem__(a, 1), ["b"]),
    "append": (lambda a, p: model().things.append(a=a, p=p), [1.0, [0, 0, 0]]),
    "extend": (lambda n, p, a: model().things.extend(n, parent=p, a=a), [2, None, 1.0]),
    "extend arrays": (lambda a, p: model().things.extend(a=a, p=p), [[1.0], [[0, 0, 0]]]),
    "popleft": (lambda a: model().queue.popleft(a), [1]),
    "remove": (lambda a: model().things.remove(a), [1]),
    "value": (lambda a: setattr(model().things.p, "value", a), [0.0]),
    "fixed": (lambda a: setattr(model().things.p, "fixed", a), [True]),
    "optimize": (lambda a: setattr(model().things[0].p, "optimize", a), [True]),
    "marginal": (COVARIANCE.marginal, ["b"]),
    "marginals": (COVARIANCE.marginals, ["things"]),
    "correlation": (COVARIANCE.correlation, ["b"]),
    "cross": (COVARIANCE.cross, ["b", "b"]),
    "conditional": (COVARIANCE.conditional, ["b", "things"]),
    "relative": (COVARIANCE.relative, ["b", "b"]),
    "ellipsoid": (COVARIANCE.ellipsoid, ["things.p", None]),
    "rms": (KEEP.cost_table().rms, ["Thing.prior"]),
    "problem.cost": (TANGENT.cost, [ZERO]),
    "problem.jacobian": (TANGENT.jacobian, [ZERO]),
    "problem.product": (TANGENT.product, [ZERO, ZERO]),
    "problem.retract": (TANGENT.retract, [ZERO]),
}

RESIDUALS: dict[str, tuple[Callable[..., Any], list[Any]]] = {
    "add": (lambda a: model().residuals.add(a), ["b - 1"]),
    "define": (lambda a, b: model().residuals.define(a, b), ["z", "2 * b"]),
    "functions": (lambda a, b: model().residuals.functions(a, b), ["fn f(x) = x", None]),
    "remove residual": (lambda a: model().residuals.remove(a), ["r"]),
    "compile": (lambda a: model().residuals.compile(a), ["r"]),
    "is_compiled": (KEEP.residuals.is_compiled, ["r"]),
    "value of": (KEEP.residuals.value, ["r"]),
    "unweighted": (KEEP.residuals.unweighted, ["r"]),
    **{
        f"add {name}": (lambda a, n=name: model().residuals.add("b - 1 [m]", **{n: a}), [None])
        for name in ("label", "parameters", "data", "entities", "loss", "when")
    },
    **{
        f"add one of {name}": (
            lambda a, n=name: model().residuals.add("b * 1 [m] - k", **{n: {"k": a}}),
            [1.0],
        )
        for name in ("parameters", "data", "entities")
    },
}

FOUND = arael.fit(CURVE, DATA)

FITS: dict[str, tuple[Callable[..., Any], list[Any]]] = {
    "fit": (arael.fit, [CURVE, DATA]),
    **{
        f"fit {name}": (lambda a, n=name: arael.fit(CURVE, DATA, **{n: a}), [None])
        for name in inspect.signature(arael.fit).parameters
        if name not in ("formula", "data", "settings")
    },
    **{
        f"fit a number in {name}": (
            lambda a, n=name: arael.fit(CURVE, DATA, **{n: {"a": a}}),
            [None],
        )
        for name in ("start", "bounds", "fixed")
    },
    "fit column": (lambda a: arael.fit(CURVE, {**DATA, "x": a}), [DATA["x"]]),
    "predict": (FOUND.predict, [{"x": [1.0]}, None]),
    "bands": (FOUND.bands, [{"x": [1.0]}, 0.95, None]),
    "profile of a fit": (FOUND.profile, ["a", 0.95]),
    "report of a fit": (FOUND.report, [0.95]),
    "table": (FOUND.table, [0.95]),
}

SETTINGS = {
    f"LmConfig {one.name}": (lambda a, n=one.name: arael.LmConfig(**{n: a}), [1])
    for one in dataclasses.fields(arael.LmConfig)
}


def by_position(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function with arguments by keyword taken by position."""
    named = inspect.signature(function).parameters.values()
    keywords = [p.name for p in named if p.kind is p.KEYWORD_ONLY]
    if not keywords:
        return function
    first = len(named) - len(keywords)
    return lambda *a: function(*a[:first], **dict(zip(keywords, a[first:], strict=True)))


def of_geometry(n: int) -> dict[str, tuple[Callable[..., Any], list[Any]]]:
    functions = {name: getattr(geometry, name) for name in geometry.__all__}
    return {
        f"geometry.{name} of {n}": (
            by_position(function),
            [np.eye(3)[:n].squeeze() for _ in inspect.signature(function).parameters],
        )
        for name, function in functions.items()
    }


CALLS = {
    **SYM,
    **MODELS,
    **RESIDUALS,
    **FITS,
    **SETTINGS,
    **of_geometry(1),
    **of_geometry(3),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_wrong_arguments_raise_arael_errors(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    function, good = CALLS[name]
    for at in range(len(good)):
        for wrong in WRONG:
            if wrong is int and name.endswith("trace"):
                continue  # a callable: its own exceptions are the caller's
            arguments = [*good[:at], wrong, *good[at + 1 :]]
            try:
                function(*arguments)
            except AraelError as error:
                assert all(d.code and d.message for d in error.diagnostics)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sym.hessian(3), "no variable to differentiate by"),
        (lambda: sym.hessian(F, 3), "E0828.*`by` must be a list of variables"),
        (lambda: sym.hessian([F, F]), "E0828.*`value` must be a scalar"),
        (lambda: sym.jacobian(F, 3), "E0828.*`by` must be a list of variables"),
        (lambda: sym.simplify(None), "E0828.*an expression.*found None"),
        (lambda: sym.c(None), "E0828.*an expression.*found None"),
        (lambda: sym.c(F, "int"), "E0828.*`real` must be `double` or `float`, found 'int'"),
        (lambda: sym.FunctionBag(3), "E0828.*the definition of a function, found 3"),
        (lambda: sym.eval(F, x="a", y=1), "E0828.*`x` must be a number.*found 'a'"),
        (lambda: sym.eval(F, x="1", y=1), "E0828.*`x` must be a number"),
        (lambda: sym.eval(F, x=[1, 2], y=[1, 2, 3]), "E0704.*do not broadcast"),
        (lambda: sym.c_function("f", F, ["x"]), "E0650.*`y` has no value"),
        (lambda: sym.diff(F, "x", 1.5), "E0652.*found 1.5"),
        (lambda: KEEP.deserialize("ab"), "E0828.*`x` must be an array of numbers, found 'ab'"),
        (lambda: KEEP.covariance().marginal(3), "E0828.*`where` must be a row"),
        (lambda: arael.fit("y = a * x + 1 [m]", DATA), "E0320.*has no units"),
        (lambda: arael.fit(CURVE, DATA, trace=3), "E0828.*`trace` must be a function"),
    ],
)
def test_the_message_names_the_argument(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(AraelError, match=f"(?s){message}"):
        call()


@pytest.mark.parametrize("n", [-1, "ab", 2.5, math.nan, True])
def test_a_wrong_number_of_rows_leaves_the_collection_unchanged(n: Any) -> None:
    made = model()
    with pytest.raises(AraelError, match="`n` must be a number of rows"):
        made.things.extend(n, a=2.0)
    assert len(made.things) == 2
    made.things.extend(a=[2.0, 3.0])
    np.testing.assert_array_equal(made.things.a.value, [1, 1, 2, 3])


@pytest.mark.parametrize("label", ["", [], 0, {}])
def test_an_empty_label_is_no_label(label: Any) -> None:
    with pytest.raises(AraelError, match="cannot be a label"):
        model().residuals.add("b - 1", label=label)
