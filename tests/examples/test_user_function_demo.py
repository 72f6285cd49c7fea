"""The example user_function_demo against inverses of its functions in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.examples.scripts import script
from tests.optional import needs

DEMO = script("user_function_demo")
# numba is no part of the extra `dev`; ctypes and cffi take a C function that the script compiles.
BINDINGS = ("ctypes", "cffi", "python")


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
@pytest.mark.parametrize("bind", BINDINGS)
def test_solution(bind: str) -> None:
    instance, result = DEMO.solved(bind)
    assert result.status == "converged"
    assert instance.x.value == pytest.approx(math.log(0.8 / 0.2), abs=1e-9)
    assert instance.y.value == pytest.approx(math.sin(0.5), abs=1e-9)
    assert result.cost < 1e-18


def test_the_function_of_c_is_that_of_python() -> None:
    function = type(DEMO.solved("ctypes")[0]).functions["my_safe_asin"]
    for x in (-2.0, -1.0, -0.3, 0.0, 0.999, 1.0, 7.0):
        assert function(x) == pytest.approx(DEMO.safe_asin(x), abs=1e-15)


def test_the_hessian_is_that_of_the_derivatives() -> None:
    """At the solution, H = 2 (isigma f')^2, with the derivatives in closed form."""
    instance, _ = DEMO.solved()
    slopes = (0.8 * 0.2, 1 / math.cos(0.5))
    for k, slope in enumerate(slopes):
        assert instance.hessian()[k, k] == pytest.approx(2 * (100 * slope) ** 2, rel=1e-6)


@needs("matplotlib")
def test_what_it_prints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    DEMO.main(["--plot", str(tmp_path / "out.png")])
    printed = capsys.readouterr().out
    assert f"x = {math.log(4):.9f}" in printed
    assert f"y = {math.sin(0.5):.9f}" in printed
    assert f"derivative {1 / math.cos(0.5):.6f}" in printed
    assert "warning" not in printed
    assert (tmp_path / "out.png").stat().st_size > 5000


def test_a_python_function_is_warned_of(capsys: pytest.CaptureFixture[str]) -> None:
    DEMO.main(["--bind", "python"])
    assert "warning: `my_safe_asin` is bound to a Python function" in capsys.readouterr().out
