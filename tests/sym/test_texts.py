"""Text in, text out: the language, Python and C, evaluated against `eval`."""

from __future__ import annotations

import ctypes
import pickle
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from arael import sym
from arael.diagnostics.records import AraelError
from tests.optional import needs
from tests.sym.formulas import NAMES, all_functions, of_symbols, points, trees


@given(trees(), points())
def test_python_text_has_the_same_value(text: str, at: list[float]) -> None:
    f = sym.parse(text)
    where = dict(zip(NAMES, at, strict=True))
    found = eval(f.python(), {"np": np, **where})
    assert float(found) == pytest.approx(f.eval(where), rel=1e-12, abs=1e-14)


@given(trees())
def test_text_is_read_back(text: str) -> None:
    f = sym.parse(text)
    assert sym.parse(str(f)) == f
    slope = f.diff("x")
    again = sym.parse(str(slope))
    assert again.eval(x=0.3, y=-0.2, z=0.7) == pytest.approx(
        slope.eval(x=0.3, y=-0.2, z=0.7), rel=1e-12, abs=1e-14
    )


@given(trees())
def test_pickled(text: str) -> None:
    f = sym.parse(text)
    assert pickle.loads(pickle.dumps(f)) == f


def test_c_text_has_the_same_value(tmp_path: Path) -> None:
    """Every function of the language, compiled."""
    formulas = [of_symbols(name) for name in all_functions()]
    formulas += [f.diff(name) for f in formulas for name in f.free_vars]
    formulas.append(sym.parse("if x < y and not x > z then x^3 else if x == y then 1 else y / z"))
    source = tmp_path / "all.c"
    x = sym.Vector(formulas)
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
        expected = x.eval(dict(zip(NAMES, point, strict=True)))
        np.testing.assert_allclose(np.array(out), expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("x^2 / (1 + x)", r"\frac{x^{2}}{1 + x}"),
        ("(a + b) * 2", r"\left(a + b\right) \cdot 2"),
        ("2 * alpha_0 * x1", r"2 \alpha_{0} x_{1}"),
        ("sqrt(abs(x))", r"\sqrt{\left|x\right|}"),
        ("-(x + y)^2", r"-\left(x + y\right)^{2}"),
        ("atan(r_max / sigma)", r"\arctan\left(\frac{r_{\mathrm{max}}}{\sigma}\right)"),
        ("1e-12 * pi", r"10^{-12} \pi"),
        ("[x, 1]", r"\begin{bmatrix} x \\ 1 \end{bmatrix}"),
        ("if x < 0 then 0 else x", None),
    ],
)
def test_latex(text: str, latex: str | None) -> None:
    found = sym.parse(text).latex()
    assert latex is None or found == latex
    assert found.count("{") == found.count("}")
    assert found.count("\\left(") == found.count("\\right)")


@needs("matplotlib")
def test_matplotlib_reads_the_latex() -> None:
    from matplotlib import mathtext

    reader = mathtext.MathTextParser("path")
    for name in all_functions():
        reader.parse(f"${of_symbols(name).latex()}$")


def test_c_and_python_text_read_well() -> None:
    f = sym.parse("p.x * sin(t) + t^2 / 3")
    assert f.python() == "p_x * np.sin(t) + t ** 2.0 / 3.0"
    assert f.c() == "p_x * sin(t) + t * t / 3.0"
    assert f.c("float") == "p_x * sinf(t) + t * t / 3.0f"
    with pytest.raises(ValueError, match="double"):
        f.c("int")


def test_a_calculated_giant_is_not_written_out() -> None:
    f = sym.symbol("x")
    for _ in range(40):
        f = f * f + f
    assert f.eval(x=0.1) > 0
    for write in (str, sym.Expr.latex, sym.Expr.c, sym.Expr.python):
        with pytest.raises(AraelError, match="E0653"):
            write(f)
