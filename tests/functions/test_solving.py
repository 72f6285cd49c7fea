"""One equation, solved through whatever can be bound: log(1 + a) = 0.5, on compiled kernels."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import scipy.special.cython_special as special
from scipy import LowLevelCallable

import arael
from tests.functions.models import libm
from tests.optional import require

MODEL = """
extern fn grown(x) derivs [1 / (1 + x)]
struct Part { goal: real; param a: real; constraint c { grown(a) - goal } }
root Whole { parts: list of Part }
"""
GOALS = [0.5, 0.25, -0.5, 1.0, 0.1]

D = ctypes.c_double


def of_cffi() -> Any:
    cffi = require("cffi")
    ffi = cffi.FFI()
    ffi.cdef("double log1p(double);")
    return ffi.dlopen(None).log1p


def callback_of_cffi() -> Any:
    cffi = require("cffi")
    return cffi.FFI().callback("double(double)", math.log1p)


def capsule() -> Any:
    """What Cython makes of `cpdef double log1p(double)`."""
    named = special.__pyx_capi__.items()
    return next(c for n, c in named if n.endswith("log1p") and '"double (double' in repr(c))


def of_numba() -> Any:
    numba = require("numba")
    return numba.cfunc("float64(float64)")(lambda x: math.log1p(x))


def array_of_numba() -> Any:
    numba = require("numba")
    kind = numba.types
    signature = kind.float64(kind.intc, kind.CPointer(kind.float64))
    return numba.cfunc(signature)(lambda n, x: math.log1p(x[0]))


WAYS: dict[str, Callable[[], Any]] = {
    "ctypes": lambda: libm("log1p"),
    "ctypes callback": lambda: ctypes.CFUNCTYPE(D, D)(math.log1p),
    "cffi": of_cffi,
    "cffi callback": callback_of_cffi,
    "Cython": capsule,
    "SciPy of ctypes": lambda: LowLevelCallable(libm("log1p")),
    "SciPy of Cython": lambda: LowLevelCallable(capsule()),
    "numba": of_numba,
    "numba, an array": array_of_numba,
    "Python": lambda: math.log1p,
}


@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
@pytest.mark.parametrize("way", WAYS)
def test_solved(tmp_path: Path, way: str) -> None:
    path = tmp_path / "grown.arael"
    path.write_text(MODEL)
    made = arael.load(path, functions={"grown": WAYS[way]()})
    model = made(parts=[{"goal": goal, "a": 0} for goal in GOALS])
    result = model.solve(rel_precision=1e-14)
    assert result.status == "converged"
    assert model.parts.a.value == pytest.approx([math.expm1(goal) for goal in GOALS], abs=1e-9)
    assert made.compiled.bindings["grown"].needs_gil is (way == "Python")
    assert made.functions["grown"](1.0) == math.log(2)
