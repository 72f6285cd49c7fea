"""The functions of a model in residuals that are given at run time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.face.native import SlowFunctionWarning
from tests.functions.models import MODEL, PYTHON, data, libm, native

U = np.linspace(-0.8, 2.1, 70)  # more than two blocks of lanes


def instance(folder: Path, bound: Any, precision: str = "f64", interpret: bool = True) -> Any:
    path = folder / "fit.arael"
    path.write_text(MODEL.replace("PRECISION", f": {precision}"))
    return arael.load(path, functions=bound, interpret=interpret)(**data())


TEXT = "[si(p.x * u) * HALF, grow(p.y) * arc(u, 2 + p.x) + both(p).y, co(u) - sigmoid(p.x)]"


def by_hand(p: Any) -> np.ndarray:
    """Residuals of TEXT (rows, 3)."""
    squashed = 1 / (1 + math.exp(-p[0]))
    return np.column_stack(
        [
            0.5 * np.sin(p[0] * U),
            math.exp(p[1]) * np.arctan2(U, 2 + p[0]) + squashed,
            np.cos(U) - squashed,
        ]
    )


@pytest.mark.parametrize("interpret", [True, False], ids=["interpreted", "beside kernels"])
def test_values_and_derivatives(tmp_path: Path, interpret: bool) -> None:
    fit = instance(tmp_path, native(), interpret=interpret)
    compiled = fit.cost()
    added = fit.residuals.add(TEXT, label="all", data={"u": U})
    np.testing.assert_allclose(added.residuals, by_hand([0.4, -0.3]), rtol=1e-13)
    expected = compiled + np.square(by_hand([0.4, -0.3])).sum()
    assert fit.cost() == pytest.approx(expected, rel=1e-13)
    before, h = fit.gradient(), 1e-6
    fit.residuals.remove("all")
    compiled_gradient = fit.gradient()
    for k in range(2):
        step = h * np.eye(2)[k]
        costs = [np.square(by_hand(np.array([0.4, -0.3]) + s)).sum() for s in (step, -step)]
        slope = (costs[0] - costs[1]) / (2 * h)
        assert before[k] - compiled_gradient[k] == pytest.approx(slope, rel=1e-7)
    fit.residuals.add(TEXT, label="all", data={"u": U})
    assert all(check.agrees for check in fit.check_gradients())


def test_single_precision(tmp_path: Path) -> None:
    fit = instance(tmp_path, native(), "f32")
    added = fit.residuals.add(TEXT, data={"u": U})
    np.testing.assert_allclose(added.residuals, by_hand([0.4, -0.3]), atol=2e-6)


def test_solving(tmp_path: Path) -> None:
    """The equation sin(a) = 0.5, by native code and by the functions of the language."""
    fit = instance(tmp_path, native())
    fit.p.fixed = True
    by_native = fit.residuals.add("si(a) - HALF", label="n", parameters={"a": 0.1})
    by_language = fit.residuals.add("sin(b) - 0.5", label="l", parameters={"b": 0.1})
    fit.solve(rel_precision=1e-12)
    assert by_native.parameters["a"] == pytest.approx(math.pi / 6, abs=1e-7)
    assert by_native.parameters["a"] == pytest.approx(by_language.parameters["b"], abs=1e-12)


def test_named_expressions_and_their_values(tmp_path: Path) -> None:
    fit = instance(tmp_path, native())
    fit.residuals.define("turned", "arc(p.x, HALF)")
    assert fit.residuals.value("turned") == pytest.approx(math.atan2(0.4, 0.5))


def test_python_functions(tmp_path: Path) -> None:
    with pytest.warns(SlowFunctionWarning):
        fit = instance(tmp_path, PYTHON)
    added = fit.residuals.add(TEXT, data={"u": U})
    np.testing.assert_allclose(added.residuals, by_hand([0.4, -0.3]), rtol=1e-13)


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
def test_what_a_python_function_raises_ends_the_solve(tmp_path: Path) -> None:
    calls = []

    def fails(x: float) -> float:
        calls.append(x)
        if len(calls) > 40:
            raise KeyError("gone")
        return math.sin(x)

    path = tmp_path / "m.arael"
    path.write_text("extern fn si(x) derivs [1]\nroot R { param a: real; constraint c { a } }")
    model = arael.load(path, functions={"si": fails}, interpret=True)(a=0.0)
    model.residuals.add("si(a * u) - 3", data={"u": U})
    for ask in (model.solve, model.jacobian):
        calls.clear()
        with pytest.raises(KeyError) as caught:
            ask()
        assert "bound to `si`" in caught.value.__notes__[0]
        assert len(calls) == 41, "no call after the one that failed"


def test_nothing_bound(tmp_path: Path) -> None:
    path = tmp_path / "m.arael"
    path.write_text("extern fn si(x) derivs [1]\nroot R { param a: real; constraint c { a } }")
    model = arael.load(path, interpret=True)(a=0.0)
    model.solve()
    model.residuals.add("si(a) - 3", label="later")
    with pytest.raises(arael.AraelError) as caught:
        model.solve()
    (found,) = caught.value.diagnostics
    assert found.code == "E0820"
    assert found.notes[0] == "`later` calls it"


def test_many_arguments(tmp_path: Path) -> None:
    names = ", ".join(f"x{k}" for k in range(40))
    path = tmp_path / "m.arael"
    ones = ", ".join(["1"] * 40)
    path.write_text(
        f"extern fn total({names}) derivs [{ones}]\n"
        "root R { param a: real; constraint c { a } }"
    )
    with pytest.warns(SlowFunctionWarning):
        made = arael.load(path, functions={"total": lambda *x: sum(x)}, interpret=True)
    model = made(a=2.0)
    text = ", ".join(f"{k} * a" for k in range(40))
    added = model.residuals.add(f"[total({text}), total({text.replace('39 *', '390 *')})]")
    assert added.residuals.tolist() == [[2 * 780, 2 * (780 + 351)]]
    assert all(check.agrees for check in model.check_gradients())


def test_functions_of_imported_files(tmp_path: Path) -> None:
    (tmp_path / "base.arael").write_text("const K = 3\nfn scaled(x) = K * x")
    main = tmp_path / "main.arael"
    main.write_text('import "base.arael"\nroot R { param a: real; constraint c { scaled(a) } }')
    for _ in ("compiled", "from the cache"):
        model = arael.load(main, interpret=True)(a=2.0)
        assert model.residuals.add("scaled(a) - K").residuals[0, 0] == 3


def test_further_functions_may_call_those_of_the_model(tmp_path: Path) -> None:
    fit = instance(tmp_path, native())
    fit.residuals.functions(
        "const D = 2 * HALF\n"
        "fn double(x) derivs [D * co(x)] = 2 * si(x)\n"
        "extern fn root3(x) derivs [1 / (3 * root3(x)^2)]",
        bind={"root3": libm("cbrt")},
    )
    added = fit.residuals.add("double(p.x) * D + root3(p.x) + si(p.y)")
    expected = 2 * math.sin(0.4) + 0.4 ** (1 / 3) + math.sin(-0.3)
    assert added.residuals[0, 0] == pytest.approx(expected, rel=1e-14)
    # The derivative is the one that `double` claims, half of the true one.
    slope = fit.gradient()
    fit.residuals.remove(added)
    mine = slope - fit.gradient()
    by_x = 2 * expected * (math.cos(0.4) + 1 / (3 * 0.4 ** (2 / 3)))
    assert mine[0] == pytest.approx(by_x, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "bind", "code"),
    [
        ("fn sigmoid(x) = x", None, "E0206"),
        ("const HALF = 1", None, "E0206"),
        ("extern fn mine(x) derivs [1]", None, "E0820"),
        ("fn mine(x) = x", {"mine": math.sin}, "E0821"),
        ("extern fn mine(x) derivs [1]", {"mine": 3}, "E0822"),
        ("extern fn mine(x) derivs [1, 2]", {"mine": math.sin}, "E0670"),
        ("fn mine(x) = mine(x)", None, "E0605"),
    ],
)
def test_refused(tmp_path: Path, text: str, bind: Any, code: str) -> None:
    fit = instance(tmp_path, native())
    with pytest.raises(arael.AraelError) as caught:
        fit.residuals.functions(text, bind)
    assert caught.value.diagnostics[0].code == code
    with pytest.raises(arael.AraelError, match="unknown function"):
        fit.residuals.add("mine(p.x)")
    assert fit.residuals.add("sigmoid(p.x)").residuals[0, 0] > 0


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
def test_a_function_declared_anew_is_bound_anew(tmp_path: Path) -> None:
    """Also for residuals that are there, and after a solve that could be continued."""
    fit = instance(tmp_path, native())
    fit.p.fixed = True
    text = "extern fn mine(x) derivs [1]"
    fit.residuals.functions(text, bind={"mine": lambda x: x - 2})
    added = fit.residuals.add("mine(a)", label="m", parameters={"a": 0})
    fit.solve(rel_precision=1e-12)
    assert added.parameters["a"] == pytest.approx(2)
    fit.residuals.functions(text, bind={"mine": lambda x: x - 3})
    fit.solve(rel_precision=1e-12)
    assert added.parameters["a"] == pytest.approx(3)
