"""User-defined functions in a model: a formula, and native code with derivatives.

    python user_function_demo.py [--bind ctypes|cffi|numba|python] [--plot user_function_demo.png]

The model is `user_function.arael` in this folder. `my_safe_asin` is native code, bound in this
script to the C function of `safe_asin.c`, or one in Python, with numba or without.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import os
import subprocess
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import arael

MODEL = Path(__file__).with_name("user_function.arael")


def safe_asin(x: float) -> float:
    """Arcsine of `x` clamped to -1 .. 1."""
    return math.asin(min(max(x, -1.0), 1.0))


def of_python() -> Any:
    """The Python function: called with the GIL held, with a warning."""
    return safe_asin


@cache
def library() -> str:
    """A shared library compiled from `safe_asin.c`."""
    made = Path(tempfile.mkdtemp(prefix="safe-asin-")) / "safe_asin.so"
    compiler = os.environ.get("CC", "cc")
    source = Path(__file__).with_name("safe_asin.c")
    command = [compiler, "-O2", "-shared", "-fPIC", str(source), "-o", str(made), "-lm"]
    subprocess.run(command, check=True)
    return str(made)


def of_ctypes() -> Any:
    """The C function through ctypes; its signature must be declared."""
    function = ctypes.CDLL(library()).safe_asin
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
    return function


def of_cffi() -> Any:
    """The C function through cffi."""
    import cffi

    ffi = cffi.FFI()
    ffi.cdef("double safe_asin(double);")
    return ffi.dlopen(library()).safe_asin


def of_numba() -> Any:
    """The Python function, compiled."""
    import numba

    return numba.cfunc("float64(float64)")(safe_asin)


BINDINGS: dict[str, Callable[[], Any]] = {
    "ctypes": of_ctypes,
    "cffi": of_cffi,
    "numba": of_numba,
    "python": of_python,
}


def solved(bind: str = "ctypes") -> tuple[Any, Any]:
    """The solved instance and the result of the solve."""
    model: Any = arael.load(MODEL, functions={"my_safe_asin": BINDINGS[bind]()})
    instance = model()
    result = instance.solve(rel_precision=1e-12)
    return instance, result


def plot(instance: Any, path: Path) -> None:
    """Draw both functions with their derivatives, and where the fit ended."""
    from arael.plot.figure import BLUE, ORANGE, new_figure, save, styled

    @styled
    def drawn() -> Any:
        figure, panels = new_figure(8.4, 3.4, columns=2)
        parts = (
            ("sigmoid", np.linspace(-5, 5, 201), instance.x.value),
            ("my_safe_asin", np.linspace(-0.97, 0.97, 195), instance.y.value),
        )
        for axes, (name, at, end) in zip(panels, parts, strict=True):
            function = type(instance).functions[name]
            axes.plot(at, function(at), color=BLUE, label=name)
            axes.plot(at, function.partials(at)[0], "--", color=ORANGE, label="its derivative")
            axes.plot(end, function(end), "o", color=BLUE)
            axes.locator_params(nbins=7)
            axes.axvline(end, color=BLUE, linewidth=0.6)
            axes.set_title(f"{name}({end:.4f}) = {function(end):.4f}")
            axes.legend()
        return figure

    save(drawn(), path)


def main(arguments: list[str] | None = None) -> None:
    """Solve, and print the solution and the model's functions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--bind", choices=BINDINGS, default="ctypes")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        instance, result = solved(args.bind)
    for warning in said:
        print(f"warning: {warning.message}")
    print(f"{result.status} after {result.iterations} iterations, cost {result.cost:.3e}")
    print(f"x = {instance.x.value:.9f}   sigmoid(x)      = {instance.sigmoid_target:g}")
    print(f"y = {instance.y.value:.9f}   my_safe_asin(y) = {instance.asin_target:g}")
    functions = type(instance).functions
    for function, at in (
        (functions["sigmoid"], instance.x),
        (functions["my_safe_asin"], instance.y),
    ):
        (slope,) = function.partials(at.value)
        print(f"{function!r}: derivative {slope:.6f} there")
    if args.plot:
        plot(instance, args.plot)


if __name__ == "__main__":
    main()
