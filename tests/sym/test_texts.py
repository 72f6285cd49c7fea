"""Text in, text out: the language, Python and C, evaluated against `eval`."""

from __future__ import annotations

import ctypes
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest
import scipy.special
import sympy as sp
from hypothesis import given, settings

from arael import sym
from arael.diagnostics.records import AraelError
from tests.optional import needs
from tests.sym.formulas import NAMES, all_functions, of_symbols, points, trees


@settings(max_examples=40)
@given(trees(), points())
def test_python_text_has_the_same_value(text: str, at: list[float]) -> None:
    f = sym.parse(text)
    where = dict(zip(NAMES, at, strict=True))
    found = eval(sym.python(f), {"np": np, **{n: np.float64(x) for n, x in where.items()}})
    close = 1e-5 if "fast" in text else 1e-14  # `fast_atan` is written as `arctan`
    assert float(found) == pytest.approx(sym.eval(f, where), rel=max(close, 1e-12), abs=close)


@pytest.mark.parametrize("name", all_functions())
def test_python_text_of_every_function(name: str) -> None:
    f = of_symbols(name)
    for point in ((0.31, 0.77, 0.9), (0.85, 0.21, 0.5)):
        where = {n: np.float64(x) for n, x in zip(NAMES, point, strict=True)}
        found = eval(sym.python(f), {"np": np, "scipy": scipy, **where})
        close = 6e-8 if "fast" in name else 0.0
        assert float(found) == pytest.approx(sym.eval(f, where), rel=1e-12, abs=close)


@settings(max_examples=60)
@given(trees())
def test_text_is_read_back(text: str) -> None:
    f = sym.parse(text)
    for written in (f, f.diff("x")):
        again = sym.parse(sym.text(written))
        expected = pytest.approx(sym.eval(written, x=0.3, y=-0.2, z=0.7), rel=1e-11, abs=1e-13)
        assert sym.eval(again, x=0.3, y=-0.2, z=0.7) == expected


@pytest.mark.parametrize(
    "text",
    [
        "(x + y)^2 - a * x^2",
        "-x * y / (w * z)",
        "b - a",
        "1 / (1 + exp(-x))",
        "x^(-y)",
        "(x^y)^z",
        "1 / sqrt(x)",
        "1 / x^2",
        "y / x^2 - z / 3",
        "x * (y - 1)",
        "sin(if x < 0 then 1 else 2)",
        "(a / b)^c",
        "x * (if x < 0 then 1 else 2)",
        "if x <= 0 then (if y < 0 then 1 else x) else 2",
        "if x != y or (y > 0 and x < 0) then 1 else 2",
        "x / 3 + 1e-06 * y",
        "sqrt(2) * pi * x",
        "[x, 2 * y]",
        "[[x, 1], [0, y]]",
        "quat(w, x, y, z)",
        "L0.length + p.x",
        "x < y",
    ],
)
def test_text_reads_well(text: str) -> None:
    names = {"m": sp.Matrix([[sp.Symbol("x"), 1], [0, sp.Symbol("y")]])}
    names["q"] = sp.Quaternion(*sp.symbols("w x y z"))
    source = {"[[x, 1], [0, y]]": "m", "quat(w, x, y, z)": "q"}.get(text, text)
    assert sym.text(sym.parse(source, names=names)) == text


def test_c_text_has_the_same_value(tmp_path: Path) -> None:
    """Every function of the language, compiled."""
    formulas = [of_symbols(name) for name in all_functions()]
    formulas += [f.diff(sp.Symbol(name)) for f in formulas for name in sym.free_vars(f)]
    formulas.append(sym.parse("if x < y and not x > z then x^3 else if x == y then 1 else y / z"))
    source = tmp_path / "all.c"
    x = sp.Matrix(formulas)
    source.write_text(sym.c_function("all", x, NAMES), encoding="utf-8")
    library = tmp_path / "all.so"
    compiler = (sysconfig.get_config_var("CC") or "cc").split()[0]
    subprocess.run(
        [compiler, "-O1", "-Werror", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True
    )
    function = ctypes.CDLL(str(library)).all
    out = (ctypes.c_double * len(formulas))()
    for point in ((0.3, 0.6, 0.7), (0.9, 0.2, 0.4), (0.1, 0.1, 0.1), (0.0, 1.0, 0.0)):
        function(*map(ctypes.c_double, point), out)
        expected = sym.eval(x, dict(zip(NAMES, point, strict=True)))
        np.testing.assert_allclose(np.array(out), expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("x^2 / (1 + x)", r"\frac{x^{2}}{x + 1}"),
        ("2 * alpha_0 * x1", r"2 \alpha_{0} x_{1}"),
        ("sqrt(abs(x))", r"\sqrt{\left|{x}\right|}"),
        ("cbrt(x)^2", r"{\sqrt[3]{x}}^{2}"),
        ("starship(r, 2)", r"\operatorname{starship}{\left(r,2 \right)}"),
    ],
)
def test_latex(text: str, latex: str) -> None:
    assert sym.latex(sym.parse(text)) == latex == sp.latex(sym.parse(text))


@needs("matplotlib")
def test_matplotlib_reads_the_latex() -> None:
    from matplotlib import mathtext

    reader = mathtext.MathTextParser("path")
    for name in all_functions():
        reader.parse(f"${sym.latex(of_symbols(name))}$")


def test_c_and_python_text_read_well() -> None:
    f = sym.parse("p.x * sin(t) + t^2 / 3")
    assert sym.python(f) == "p_x*np.sin(t) + (1/3)*t**2"
    own = sym.parse("hypot(expm1(x), y) * identity(x + y)")
    assert sym.python(own) == "np.hypot(np.expm1(x), y)*(+(x + y))", "as the table names them"
    assert sym.c(f) == "t * t / 3.0 + p_x * sin(t)"
    assert sym.c(f, "float") == "t * t / 3.0f + p_x * sinf(t)"
    assert sym.c(sym.parse("[x, 1]")) == "{x, 1.0}"
    assert sym.python(sym.parse("[x, pi]")) == "np.array([x, np.pi])"
    with pytest.raises(AraelError, match="double"):
        sym.c(f, "int")


def test_a_calculated_giant_is_not_written_out() -> None:
    f = sym.symbol("x")
    for _ in range(40):
        f = f * sp.sin(f) + f
    assert sym.eval(f, x=0.001) > 0
    for write in (sym.text, sym.latex, sym.c, sym.python):
        with pytest.raises(AraelError, match="E0653"):
            write(f)


def test_c_of_nested_composed_functions_is_bounded() -> None:
    nested = sym.parse("digamma(digamma(digamma(digamma(x))))")
    with pytest.raises(AraelError, match="E0653"):
        sym.c(nested)
