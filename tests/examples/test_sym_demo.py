"""The tour of symbolic mathematics, its figures against computations of their own."""

from __future__ import annotations

import importlib.util
import math
import sys
from pathlib import Path
from types import ModuleType

import pytest
import sympy as sp

from arael import sym
from tests.optional import needs
from tests.sym.formulas import central

FOLDER = Path(__file__).parents[2] / "examples" / "sym_demo"


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    spec = importlib.util.spec_from_file_location("sym_demo", FOLDER / "sym_demo.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@needs("matplotlib")
def test_it_runs(
    demo: ModuleType,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    picture = tmp_path / "sym_demo.png"
    monkeypatch.setattr(sys, "argv", ["sym_demo.py", "--plot", str(picture)])
    demo.main()
    out = capsys.readouterr().out
    assert "f'(x)   = x * cos(x) + sin(x)\n" in out
    assert f"f(2)    = {2 * math.sin(2) + 1!r}\n" in out
    assert "simple  = x + 2\n" in out
    assert "q v q* - R v: equal to rounding" in out
    s = 1 / (1 + math.exp(-1.0))
    slope = 2 * s * (1 - s) + 0.5 / math.sqrt(0.25 + 1e-6)
    assert f"f'(0.5) = {round(slope, 12)}\n" in out
    assert picture.stat().st_size > 5000


def test_second_derivative_against_sympy(demo: ModuleType) -> None:
    x = sp.Symbol("x")
    oracle = sp.diff(sp.sin(x) * x + 1, x, 2)
    found = sym.diff(demo.building(), "x", 2)
    for at in (-1.3, 0.0, 0.4, 7.0):
        assert sym.eval(found, x=at) == pytest.approx(float(oracle.subs(x, at)), abs=1e-14)


def test_shared_rows_against_central_differences(demo: ModuleType) -> None:
    at = {"a": 0.4, "b": -0.3, "x": 5.0, "y": 2.0, "isigma": 30.0}
    shared = demo.sharing()
    known = dict(at)
    for name, value in shared.temporaries:
        known[name.name] = sym.eval(value, known)
    residual = sym.parse("3 * atan(atan2(y - b, x - a) * isigma / 3)")
    row = sym.eval(shared.values[0], known)[0]
    for i, name in enumerate("ab"):
        assert row[i] == pytest.approx(central(residual, name, at), rel=1e-6)
