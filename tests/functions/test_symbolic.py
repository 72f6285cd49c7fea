"""The functions of a model on symbolic expressions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import arael
from arael import sym
from arael.functions import Functions
from tests.functions.models import MODEL, PYTHON, native

T = sym.symbol("t")


def functions_of(folder: Path, bound: Any = None) -> Functions:
    path = folder / "fit.arael"
    path.write_text(MODEL.replace("PRECISION", ""))
    found = arael.load(path, functions=bound, interpret=True).functions
    assert isinstance(found, Functions)
    return found


@pytest.fixture
def functions(tmp_path: Path) -> Functions:
    return functions_of(tmp_path, native())


def test_a_formula_is_written_out_and_differentiated(functions: Functions) -> None:
    found = functions["sigmoid"](2 * T)
    assert sym.text(found) == "1 / (1 + exp(-2 * t))"
    assert sym.eval(found.diff("t"), t=0.3) == pytest.approx(
        2 * math.exp(-0.6) / (1 + math.exp(-0.6)) ** 2
    )


def test_vectors_in_and_out_and_constants(functions: Functions) -> None:
    assert sym.text(functions["pair"](T, 3)) == "[3 * t, t + 3 / 2]", "HALF is 0.5"
    both = functions["both"](sym.vector("p", 2))
    assert sym.text(both) == "[p.x * p.y, 1 / (1 + exp(-p.x))]"
    np.testing.assert_allclose(
        sym.eval(functions["both"](sp.Matrix([1, 2]))), [2, 1 / (1 + math.exp(-1))]
    )


def test_derivatives_of_their_own(functions: Functions) -> None:
    """Recursion through `derivs`, of one function and of two."""
    assert sym.text(functions["grow"](T).diff(T, 3)) == "grow(t)"
    assert sym.text(functions["si"](T).diff(T)) == "co(t)"
    assert sym.text(functions["si"](T).diff(T, 4)) == "si(t)"
    assert sym.eval(functions["si"](2 * T).diff(T, 2), t=0.4) == pytest.approx(-4 * math.sin(0.8))


def test_partials(functions: Functions) -> None:
    by_y, by_x = functions["arc"].partials(T, 2.0)
    assert (sym.eval(by_y, t=0.5), sym.eval(by_x, t=0.5)) == pytest.approx(
        functions["arc"].partials(0.5, 2.0)
    )
    by_x, by_y = functions["pair"].partials(T, sym.symbol("x"))
    assert (sym.text(by_x), sym.text(by_y)) == ("[x, 1]", "[t, 1 / 2]")


def test_in_text(functions: Functions) -> None:
    found = sym.parse("si(t)^2 + sigmoid(t) * HALF", functions.bag, functions.bag.constants)
    expected = math.sin(0.7) ** 2 + 0.5 / (1 + math.exp(-0.7))
    assert sym.eval(found, t=0.7) == pytest.approx(expected, rel=1e-15)


def test_python_functions_too(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="bound to Python functions"):
        functions = functions_of(tmp_path, PYTHON)
    assert sym.eval(functions["arc"](T, 2), t=1.0) == math.atan2(1, 2)


def test_without_native_code_there_are_derivatives_but_no_values(tmp_path: Path) -> None:
    functions = functions_of(tmp_path)
    slope = functions["arc"](T, 2).diff(T)
    assert sym.eval(slope, t=1.0) == pytest.approx(2 / 5)
    with pytest.raises(arael.AraelError) as caught:
        sym.eval(functions["arc"](T, 2), t=1.0)
    assert caught.value.diagnostics[0].code == "E0820"


def test_numbers_for_a_function_of_vectors(functions: Functions) -> None:
    with pytest.raises(arael.AraelError) as caught:
        functions["both"](3)
    (found,) = caught.value.diagnostics
    assert found.code == "E0302"
    assert "sympy.Matrix" in found.help[0]
    with pytest.raises(TypeError, match="takes 1 arguments, found 2"):
        functions["both"](T, T)


FILES = {
    "main.arael": 'import "parts/shapes.arael"\n'
    "root R { param a: real; constraint c { area(a) - scaled(K) } }",
    "parts/shapes.arael": 'import "base.arael"\nfn area(r) = PI2 / 2 * r ^ 2',
    "parts/base.arael": "const PI2 = 2 * pi  # a turn\nconst K = 3\n"
    "fn scaled(x) derivs [K] = (x *  # three times\n    K)",
}


@pytest.fixture
def imported(tmp_path: Path) -> Path:
    (tmp_path / "parts").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "main.arael"


def test_functions_and_constants_of_imported_files(imported: Path) -> None:
    for _ in ("compiled", "from the cache"):
        functions = arael.load(imported, interpret=True).functions
        assert functions["area"](2.0) == pytest.approx(4 * math.pi)
        assert sym.eval(functions["area"](T).diff(T), t=2.0) == pytest.approx(4 * math.pi)
        assert functions["scaled"](T).diff(T) == 3
        assert sym.eval(functions["scaled"](T), t=5) == 15
        assert functions["scaled"].formula == "x * K"


def test_a_bag_of_a_file_takes_imports_and_constants_along(imported: Path) -> None:
    bag = sym.FunctionBag.from_model(imported)
    assert sorted(bag) == ["area", "scaled"]
    assert sym.eval(bag["area"](T), t=1.0) == pytest.approx(math.pi)
    doubled = sym.FunctionBag.from_model("const TWICE = [2, 2]\nfn f(v) = dot(v, TWICE)")["f"]
    assert doubled(sp.Matrix([3, 4])) == 14
