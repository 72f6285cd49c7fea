"""What can be bound to a native function, and what cannot."""

from __future__ import annotations

import ctypes
import math
import os
import shlex
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

import pytest
import scipy.special.cython_special as special
from scipy import LowLevelCallable

import arael
from arael.compiler.build import find_compiler
from tests.functions.models import libm
from tests.optional import require

MODEL = """
extern fn f(x, y) derivs [1, 1]
extern fn g(x) derivs [1]
extern fn h(a, b, c, d, p, q, r) derivs [1, 1, 1, 1, 1, 1, 1]
fn formula(x) = x
root Fit { param a: real; constraint c { a } }
"""

D = ctypes.c_double
PD = ctypes.POINTER(D)


def load(folder: Path, **functions: Any) -> Any:
    path = folder / "fit.arael"
    path.write_text(MODEL)
    return arael.load(path, functions=functions, interpret=True)


def weighted(x: float, y: float) -> float:
    return 10 * x + y


@pytest.mark.parametrize(
    "bound",
    [
        ctypes.CFUNCTYPE(D, D, D)(weighted),
        ctypes.CFUNCTYPE(ctypes.c_float, ctypes.c_float, ctypes.c_float)(weighted),
        ctypes.CFUNCTYPE(D, ctypes.c_int, PD)(lambda n, x: 10 * x[0] + x[n - 1]),
        ctypes.CFUNCTYPE(D, ctypes.c_int, PD, ctypes.c_void_p)(lambda n, x, _: 10 * x[0] + x[1]),
        LowLevelCallable(ctypes.CFUNCTYPE(D, D, D)(weighted)),
        weighted,
    ],
    ids=["double", "float", "array", "array-user-data", "low-level", "python"],
)
@pytest.mark.filterwarnings("ignore::arael.face.native.SlowFunctionWarning")
def test_signatures(tmp_path: Path, bound: Any) -> None:
    f = load(tmp_path, f=bound).functions["f"]
    assert f.bound
    assert f(1.5, 0.25) == 15.25
    assert list(f([1.0, 2.0], 0.5)) == [10.5, 20.5]


def test_user_data(tmp_path: Path) -> None:
    scale = (D * 2)(100.0, 7.0)

    def scaled(x: float, y: float, user: int) -> float:
        found = ctypes.cast(user, PD)
        return float(found[0] * x + found[1] * y)

    pointer = ctypes.CFUNCTYPE(D, D, D, ctypes.c_void_p)(scaled)
    bound = LowLevelCallable(pointer, ctypes.cast(scale, ctypes.c_void_p))
    assert load(tmp_path, f=bound).functions["f"](2, 3) == 221


def test_many_arguments_go_as_an_array(tmp_path: Path) -> None:
    bound = ctypes.CFUNCTYPE(D, ctypes.c_int, PD)(lambda n, x: sum(x[:n]))
    assert load(tmp_path, h=bound).functions["h"](*range(7)) == 21


def test_capsule_of_cython(tmp_path: Path) -> None:
    capsule = next(
        c for n, c in special.__pyx_capi__.items() if "erfinv" in n and '"double ' in repr(c)
    )
    g = load(tmp_path, g=capsule).functions["g"]
    assert math.erf(g(0.3)) == pytest.approx(0.3, rel=1e-12)
    assert load(tmp_path, g=LowLevelCallable(capsule)).functions["g"](0.3) == g(0.3)


class Compiled:
    """What numba's `cfunc` makes, so far as it is looked at."""

    def __init__(self) -> None:
        self.ctypes = ctypes.CFUNCTYPE(D, D)(lambda x: 3 * x)
        self.address = ctypes.cast(self.ctypes, ctypes.c_void_p).value


def test_numba(tmp_path: Path) -> None:
    found = load(tmp_path, g=Compiled())
    assert found.functions["g"](2) == 6
    assert not found.compiled.bindings["g"].needs_gil


def test_cffi(tmp_path: Path) -> None:
    cffi = require("cffi")
    ffi = cffi.FFI()
    ffi.cdef("double cos(double); float sinf(float); extern const double y;")
    library = ffi.dlopen(None)
    assert load(tmp_path, g=library.cos).functions["g"](0.5) == math.cos(0.5)
    assert load(tmp_path, g=library.sinf).functions["g"](0.5) == pytest.approx(math.sin(0.5))
    with pytest.raises(arael.AraelError, match="cffi data of type"):
        load(tmp_path, g=ffi.new("double *"))
    with pytest.raises(arael.AraelError, match=r"signature `double \(double\)`"):
        load(tmp_path, f=library.cos)


def test_a_function_of_ones_own_library(tmp_path: Path) -> None:
    compiler = find_compiler()
    assert compiler is not None
    source = tmp_path / "half.c"
    source.write_text("double half(double x) { return x / 2; }\n")
    library = tmp_path / ("half" + (sysconfig.get_config_var("SHLIB_SUFFIX") or ".so"))
    command = shlex.split(os.environ.get("CC", "")) or [compiler]
    subprocess.run([*command, "-shared", "-fPIC", str(source), "-o", str(library)], check=True)
    half = ctypes.CDLL(str(library)).half
    with pytest.raises(arael.AraelError) as caught:
        load(tmp_path, g=half)
    assert "set its `restype` to `ctypes.c_double`" in caught.value.diagnostics[0].help[0]
    half.restype, half.argtypes = D, [D]
    assert load(tmp_path, g=half).functions["g"](5) == 2.5


@pytest.mark.parametrize(
    ("name", "bound", "code", "message"),
    [
        ("ff", math.sin, "E0821", "the model has no native function `ff`"),
        ("formula", math.sin, "E0821", "`formula` is a formula of the model"),
        ("f", libm("sin"), "E0822", "takes 2 arguments, but is bound to native code of signature "
         "`double (double)`"),
        ("g", ctypes.CFUNCTYPE(D, PD)(lambda x: 1.0), "E0822", "`double (double *)`"),
        ("g", ctypes.CFUNCTYPE(ctypes.c_int, D)(int), "E0822", "without a signature"),
        ("g", ctypes.CFUNCTYPE(D, D)(), "E0822", "null pointer"),
        ("g", 3.0, "E0822", "a float, which cannot be called"),
        ("g", None, "E0822", "None, which cannot be called"),
        ("h", ctypes.CFUNCTYPE(D, *[D] * 7)(lambda *x: 1.0), "E0822", "takes 7 arguments"),
    ],
)  # fmt: skip
def test_refused(tmp_path: Path, name: str, bound: Any, code: str, message: str) -> None:
    with pytest.raises(arael.AraelError) as caught:
        load(tmp_path, **{name: bound})
    (found,) = caught.value.diagnostics
    assert (found.code, message in found.message) == (code, True), found.message


def test_a_misspelt_name_gets_a_suggestion(tmp_path: Path) -> None:
    path = tmp_path / "m.arael"
    path.write_text("extern fn my_asin(x) derivs [1]\nroot R { param a: real; constraint c { a } }")
    with pytest.raises(arael.AraelError) as caught:
        arael.load(path, functions={"my_asim": math.asin}, interpret=True)
    assert caught.value.diagnostics[0].help == ("did you mean `my_asin`?",)
