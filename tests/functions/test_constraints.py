"""Functions with derivatives of their own in constraints: kernels, interpreter, differences."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.analysis.gradients import check_gradients
from arael.compiler import cache
from arael.face.native import SlowFunctionWarning
from arael.solving import problem_of
from tests.functions.models import MODEL, PYTHON, data, native


def instance(folder: Path, bound: Any, precision: str = "f64", interpret: bool = False) -> Any:
    path = folder / "fit.arael"
    path.write_text(MODEL.replace("PRECISION", f": {precision}"))
    return arael.load(path, functions=bound, interpret=interpret)(**data())


def by_hand(p: Any) -> list[float]:
    """Residuals of all active points, as the model says."""
    found = []
    for point in data()["points"]:
        u, v = point["u"], point["v"]
        if math.cos(u) > 0:
            sigmoid = 1 / (1 + math.exp(-p[1]))
            found += [
                math.sin(p[0] * u) - v,
                math.exp(0.3 * p[1]) * math.atan2(u, 2 + p[1]) + p[0] * p[1] - math.sin(u),
                sigmoid - 0.1 * v,
            ]
    return found


@pytest.mark.parametrize("interpret", [False, True])
def test_values_and_derivatives(tmp_path: Path, interpret: bool) -> None:
    fit = instance(tmp_path, native(), interpret=interpret)
    expected = by_hand([0.4, -0.3])
    assert 3 * 15 < len(expected) < 3 * 30, "the guard calls native code too"
    assert fit.cost() == pytest.approx(np.dot(expected, expected), rel=1e-13)
    h = 1e-6
    for k in range(2):
        plus, minus = [0.4, -0.3], [0.4, -0.3]
        plus[k] += h
        minus[k] -= h
        slope = (np.square(by_hand(plus)).sum() - np.square(by_hand(minus)).sum()) / (2 * h)
        assert fit.gradient()[k] == pytest.approx(slope, rel=1e-7)
    assert all(check.agrees for check in check_gradients(problem_of(fit)))


def test_kernels_and_interpreter_agree(tmp_path: Path) -> None:
    fit, slow = (instance(tmp_path, native(), interpret=i) for i in (False, True))
    np.testing.assert_allclose(fit.hessian(), slow.hessian(), rtol=1e-12)
    np.testing.assert_allclose(fit.gradient(), slow.gradient(), rtol=1e-12)


def test_single_precision(tmp_path: Path) -> None:
    fit = instance(tmp_path, native(), "f32")
    expected = by_hand([0.4, -0.3])
    assert fit.cost() == pytest.approx(np.dot(expected, expected), rel=1e-5)
    assert fit.solve().cost == pytest.approx(instance(tmp_path, native()).solve().cost, rel=1e-3)


def test_python_functions_give_the_same_and_say_that_they_are_slow(tmp_path: Path) -> None:
    with pytest.warns(SlowFunctionWarning) as said:
        slow = instance(tmp_path, PYTHON)
    names = ", ".join(f"`{name}`" for name in PYTHON)
    assert [str(w.message).split(":")[0] for w in said] == [
        f"{names} are bound to Python functions"
    ]
    fast = instance(tmp_path, native())
    assert slow.solve().cost == pytest.approx(fast.solve().cost, rel=1e-12)
    np.testing.assert_allclose(slow.p.value, fast.p.value, rtol=1e-12)


def test_what_is_bound_is_no_part_of_what_is_compiled(tmp_path: Path) -> None:
    """Another function under the same name takes effect without another compilation."""
    first = instance(tmp_path, native())
    before = {key for key, one, _ in cache.entries() if one.name == "fit"}
    changed = instance(tmp_path, native() | {"co": native()["si"]})
    assert changed.cost() != first.cost()
    assert type(changed).compiled.origin == "cache"
    assert {key for key, one, _ in cache.entries() if one.name == "fit"} == before
    assert instance(tmp_path, native()).cost() == first.cost()
    text = "".join(p.read_text() for p in type(first).compiled.folder.glob("*.pyx"))
    assert "native_si" in text
    assert not any(str(b.address) in text for b in type(first).compiled.bindings.values())


def test_no_python_in_native_calls(tmp_path: Path) -> None:
    """A native function that would fail under the GIL's absence is none: libm is called as is."""
    compiled = type(instance(tmp_path, native())).compiled
    assert not any(b.needs_gil for b in compiled.bindings.values())


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
def test_what_a_python_function_raises_ends_the_solve(tmp_path: Path) -> None:
    calls = []

    def fails(x: float) -> float:
        calls.append(x)
        if len(calls) > 100:
            raise KeyError("gone")
        return math.sin(x)

    fit = instance(tmp_path, PYTHON | {"si": fails})
    with pytest.raises(KeyError) as caught:
        fit.solve()
    assert "bound to `si`" in caught.value.__notes__[0]
    assert len(calls) == 101, "no call after the one that failed"
    np.testing.assert_array_equal(fit.p.value, [0.4, -0.3])


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
@pytest.mark.parametrize("interpret", [False, True])
@pytest.mark.parametrize("error", [ValueError("gone"), ZeroDivisionError("gone")])
def test_an_error_of_arithmetic_in_a_python_function_is_no_rejected_step(
    tmp_path: Path, interpret: bool, error: Exception
) -> None:
    """The solve ends with it, names the function, and leaves the model as it was."""
    calls = []

    def fails(x: float) -> float:
        calls.append(x)
        if len(calls) > 250:
            raise error
        return math.sin(x)

    fit = instance(tmp_path, PYTHON | {"si": fails}, interpret=interpret)
    with pytest.raises(type(error), match="gone") as caught:
        fit.solve()
    assert "in the function bound to `si`, called with (" in caught.value.__notes__[0]
    assert len(calls) == 251
    np.testing.assert_array_equal(fit.p.value, [0.4, -0.3])
    calls.clear()
    assert fit.cost() > 0, "the next evaluation starts afresh"


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
@pytest.mark.parametrize("interpret", [False, True])
def test_where_a_python_function_has_no_value(tmp_path: Path, interpret: bool) -> None:
    fit = instance(tmp_path, PYTHON | {"arc": lambda y, x: math.nan}, interpret=interpret)
    with pytest.raises(arael.SolveError) as caught:
        fit.solve()
    (found,) = caught.value.diagnostics
    assert found.code == "E1001"
    assert "`arc` of (-0.8, 1.7) is nan" in "\n".join(found.notes)


def test_nothing_bound(tmp_path: Path) -> None:
    fit = instance(tmp_path, None)
    with pytest.raises(arael.AraelError) as caught:
        fit.solve()
    assert [d.code for d in caught.value.diagnostics] == ["E0820"] * 3
    assert 'functions={"si": ...}' in caught.value.diagnostics[0].help[0]
    assert "fit.arael:" in caught.value.diagnostics[0].origin
