"""C functions that evaluate residuals: function pointers of ctypes, numba, cffi and Cython.

Signature, with 0 as the result or 1 + the number of the instance that failed::

    int f(int64_t n, const double **parameters, const double **data,
          double *residuals, double **jacobians)

All arrays are row-major f64. ``parameters[k]`` has n rows of the stored scalars of parameter k,
``data[k]`` n rows of data column k in the order of `data`. The function fills ``residuals``
(n, size) and each ``jacobians[k]`` (n, size, dim), unless ``jacobians`` is NULL: then only
residuals are needed.
"""

from __future__ import annotations

import ctypes
import re
import sys
from _ctypes import CFuncPtr
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.residuals.messages import error

Floats = NDArray[np.float64]

SIGNATURE = (
    "int (int64_t n, const double **parameters, const double **data, double *residuals, "
    "double **jacobians)"
)
# ctypes releases the GIL while a function of this prototype runs.
_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int64, *[ctypes.c_void_p] * 4)
_WHOLE = (ctypes.c_int64, ctypes.c_long, ctypes.c_longlong, ctypes.c_ssize_t)


@dataclass(frozen=True)
class NativeCode:
    """A C function; `keep` is what the caller gave, which owns its memory."""

    keep: Any
    address: int

    def __call__(
        self,
        values: Sequence[Floats],
        data: Sequence[Floats],
        size: int,
        widths: Sequence[int] | None,
    ) -> tuple[int, Floats, list[Floats]]:
        """Call the function without the GIL.

        Returns
        -------
        Its result, residuals (n, size) and Jacobians (n, size, width), none if `widths` is None
        """
        n = len(values[0])
        residuals = np.zeros((n, size))
        jacobians = [np.zeros((n, size, width)) for width in widths or ()]
        code = _PROTOTYPE(self.address)(
            n,
            _pointers(values),
            _pointers(data),
            residuals.ctypes.data,
            None if widths is None else _pointers(jacobians),
        )
        return int(code), residuals, jacobians


def _pointers(arrays: Sequence[Floats]) -> Any:
    made = (ctypes.c_void_p * max(len(arrays), 1))(*[one.ctypes.data for one in arrays])
    return ctypes.cast(made, ctypes.c_void_p)


def native_code(handle: Any, label: str) -> NativeCode | None:
    """`handle` as a C function; None if it is none.

    Raises
    ------
    AraelError
        E0770: a C function of another signature, which would crash the process.
    """
    inner = getattr(handle, "ctypes", None)
    if isinstance(getattr(handle, "address", None), int) and isinstance(inner, CFuncPtr):
        return _of_ctypes(handle, inner, label)  # numba
    if isinstance(handle, CFuncPtr):
        return _of_ctypes(handle, handle, label)
    backend = sys.modules.get("_cffi_backend")
    if backend is not None and isinstance(handle, backend._CDataBase):
        ffi = backend.FFI()
        return _checked(handle, int(ffi.cast("intptr_t", handle)), ffi.typeof(handle).cname, label)
    if type(handle).__name__ == "PyCapsule":
        api = ctypes.pythonapi
        name = ctypes.PYFUNCTYPE(ctypes.c_char_p, ctypes.py_object)(("PyCapsule_GetName", api))(
            handle
        )
        address = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
            ("PyCapsule_GetPointer", api)
        )(handle, name)
        return _checked(handle, address or 0, (name or b"").decode("utf-8", "replace"), label)
    return None


def _of_ctypes(handle: Any, function: Any, label: str) -> NativeCode:
    argument_types = function.argtypes
    fits = (
        argument_types is not None
        and len(argument_types) == 5
        and argument_types[0] in _WHOLE
        and all(
            argument_type is ctypes.c_void_p or hasattr(argument_type, "_type_")
            for argument_type in argument_types[1:]
        )
        and not any(
            argument_type in (ctypes.c_double, ctypes.c_float) for argument_type in argument_types
        )
        and function.restype in (ctypes.c_int, ctypes.c_int32)
    )
    if not fits:
        raise _wrong(
            label,
            "set `restype = ctypes.c_int` and "
            "`argtypes = [ctypes.c_int64] + [ctypes.c_void_p] * 4`",
        )
    return NativeCode(handle, ctypes.cast(function, ctypes.c_void_p).value or 0)


def _checked(handle: Any, address: int, signature: str, label: str) -> NativeCode:
    match = re.search(r"^\s*(\w+)\s*(?:\(\*\))?\s*\(([^()]*)\)", signature)
    types = [] if match is None else [_type(part) for part in match[2].split(",")]
    expected = ["double**", "double**", "double*", "double**"]
    whole = ("int64_t", "long", "longlong", "Py_ssize_t", "npy_intp", "intp_t")
    if match is None or match[1] != "int" or types[1:] != expected or types[0] not in whole:
        raise _wrong(label, f"found `{' '.join(signature.split())}`")
    return NativeCode(handle, address)


def _type(text: str) -> str:
    words = [w for w in text.replace("*", " * ").split() if w != "const"]
    kinds = [w for w in words if w in ("double", "int64_t", "long", "Py_ssize_t", "npy_intp")]
    kinds += [w for w in words if w.endswith("intp_t")]
    base = "longlong" if words.count("long") == 2 else (kinds[0] if kinds else "")
    return base + "*" * words.count("*")


def _wrong(label: str, detail: str) -> Exception:
    return error("E0770", f"a C function of another signature than `{SIGNATURE}`", label, detail)
