"""Converts the binding of a native function to an address, after checking its signature.

A call with the wrong arguments would crash the process, so functions without a known signature are
rejected.
"""

from __future__ import annotations

import ctypes
import re
import sys
import warnings
from _ctypes import CFuncPtr
from collections.abc import Callable, Mapping
from typing import Any

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.layout import Function, Layout
from arael.runtime.machine.native_binding import (
    ARRAY,
    ARRAY_USER,
    DISPATCHED,
    LARGEST_ARITY,
    PYTHON,
    SCALARS,
    SCALARS_USER,
    SINGLE,
    Binding,
)

# The last parameter of Cython's `cpdef` functions.
_SKIP = "__pyx_skip_dispatch"


class SlowFunctionWarning(UserWarning):
    """A Python function is bound in place of native code: each call takes the GIL."""


def bind_all(
    layout: Layout, functions: Mapping[str, Any], stacklevel: int = 3
) -> dict[str, Binding]:
    """Bindings for the native functions of a model.

    Parameters
    ----------
    layout : the compiled model
    functions : maps the name of an ``extern fn`` to a function pointer of ctypes or cffi, a
        numba ``cfunc``, a capsule of Cython's ``__pyx_capi__``, a `scipy.LowLevelCallable`, or a
        Python function of floats

    Raises
    ------
    AraelError
        E0821 for a name that is not a native function of the model, E0822 for an object that cannot
        be called with the function's arguments.

    Warns
    -----
    SlowFunctionWarning
        A Python function is bound.
    """
    if not isinstance(functions, Mapping):
        raise wrong_argument(
            "load", "functions", "a mapping by name", functions, 'write `{"name": function}`'
        )
    known = {f.name: f for f in layout.functions}
    found, slow = {}, []
    for name, given in functions.items():
        if name not in known or not known[name].native:
            raise AraelError(_unknown(name, known, layout))
        found[name] = bind(known[name], given)
        if found[name].needs_gil:
            slow.append(f"`{name}`")
    if slow:
        are = "is bound to a Python function: it is"
        if len(slow) > 1:
            are = "are bound to Python functions: these are"
        warnings.warn(
            f"{', '.join(slow)} {are} called for one instance at a time "
            "with the GIL held, which is slow; numba.cfunc, ctypes, cffi and Cython make "
            "functions that are called directly",
            SlowFunctionWarning,
            stacklevel=stacklevel,
        )
    return found


def bind(function: Function, given: Any) -> Binding:
    """The binding of one native function; AraelError E0822 if `given` does not fit it."""
    for recognise in (_low_level, _numba, _ctypes, _cffi, _capsule):
        binding = recognise(function, given)
        if binding is not None:
            return binding
    if callable(given):
        return Binding(given, PYTHON)
    raise _wrong(
        function,
        f"`{function.name}` is bound to {_kind(given)}, which cannot be called",
        "give a function pointer (ctypes, cffi, numba.cfunc, Cython, scipy.LowLevelCallable) "
        "or a Python function",
    )


def _native(
    function: Function, given: Any, address: int, signature: str, user_data: int = 0
) -> Binding:
    """Native code at `address`, if its signature is one that kernels can call."""
    if not address:
        raise _wrong(
            function,
            f"`{function.name}` is bound to a null pointer",
            "pass a valid function pointer, for example from a library",
        )
    shown, result, arguments = _parsed(signature)
    n = len(function.params)
    style = None
    if result == "double" and arguments == ["double"] * n:
        style = SCALARS
    elif result == "double" and arguments == ["double"] * n + ["void*"]:
        style = SCALARS_USER
    elif result == "double" and arguments == ["double"] * n + [_SKIP]:
        style = DISPATCHED
    elif result == "float" and n and arguments == ["float"] * n:
        style = SINGLE
    elif result == "double" and arguments == ["int", "double*"]:
        style = ARRAY
    elif result == "double" and arguments == ["int", "double*", "void*"]:
        style = ARRAY_USER
    if style is None or (style not in (ARRAY, ARRAY_USER) and n > LARGEST_ARITY):
        raise _wrong(
            function,
            f"`{function.name}` takes {n} argument{'s' * (n != 1)}, but is bound to native code "
            f"of signature `{shown}`",
            _expected(n),
        )
    return Binding(given, style, address, user_data, shown)


def _expected(n: int) -> str:
    forms = ["double (int n, double *x)"]
    if n <= LARGEST_ARITY:
        forms.insert(0, f"double ({', '.join(['double'] * n) or 'void'})")
    return f"expected `{'` or `'.join(forms)}`"


def _parsed(signature: str) -> tuple[str, str, list[str]]:
    """Split a signature into its text, the type of its result, and those of its arguments."""
    match = re.fullmatch(r"\s*([\w ]+?)\s*\(([^()]*)\)\s*(?:noexcept)?\s*(?:nogil)?\s*", signature)
    shown = " ".join(signature.split())
    if match is None:
        return shown, "", []
    arguments = [_type(a) for a in match[2].split(",")]
    return shown, match[1], [] if arguments in ([""], ["void"]) else arguments


def _type(text: str) -> str:
    """Type of an argument, without `const` and without the argument's name."""
    words = text.replace("*", " * ").split()
    words = [w for w in words if w != "const"]
    if words == ["int", _SKIP]:
        return _SKIP
    base = words[0] if words else ""
    return base + "*" * words.count("*")


# --- supported objects
# -----------------------------------------------------------------------------


def _ctypes(function: Function, given: Any) -> Binding | None:
    if not isinstance(given, CFuncPtr):
        return None
    if getattr(given, "_flags_", 0) & 4:  # FUNCFLAG_PYTHONAPI: it must be called with the GIL
        return Binding(given, PYTHON)
    if given.argtypes is None or given.restype not in (ctypes.c_double, ctypes.c_float):
        raise _wrong(
            function,
            f"`{function.name}` is bound to a function of ctypes without a signature and gives",
            "set its `restype` to `ctypes.c_double` and its `argtypes` to "
            f"`[{', '.join(['ctypes.c_double'] * len(function.params))}]`",
        )
    arguments = ", ".join(_ctypes_name(t) for t in given.argtypes)
    signature = f"{_ctypes_name(given.restype)} ({arguments})"
    address = ctypes.cast(given, ctypes.c_void_p).value or 0
    return _native(function, given, address, signature)


def _ctypes_name(type_: Any) -> str:
    names = {ctypes.c_double: "double", ctypes.c_float: "float", ctypes.c_int: "int"}
    names |= {ctypes.POINTER(ctypes.c_double): "double *", ctypes.c_void_p: "void *"}
    return names.get(type_, getattr(type_, "__name__", "unknown").removeprefix("c_"))


def _cffi(function: Function, given: Any) -> Binding | None:
    backend = sys.modules.get(
        "_cffi_backend"
    )  # a pointer of cffi exists only if the module is imported
    if backend is None or not isinstance(given, backend._CDataBase):
        return None
    ffi = backend.FFI()
    kind = ffi.typeof(given)
    if kind.kind != "function":
        raise _wrong(
            function,
            f"`{function.name}` is bound to cffi data of type `{kind.cname}`",
            "give a function: `ffi.addressof(lib, 'name')` or a pointer to one",
        )
    signature = f"{kind.result.cname} ({', '.join(a.cname for a in kind.args)})"
    return _native(function, given, int(ffi.cast("intptr_t", given)), signature)


def _numba(function: Function, given: Any) -> Binding | None:
    inner = getattr(given, "ctypes", None)
    if not isinstance(getattr(given, "address", None), int) or not isinstance(inner, CFuncPtr):
        return None
    binding = _ctypes(function, inner)
    assert binding is not None
    return Binding(given, binding.style, given.address, 0, binding.signature)


def _low_level(function: Function, given: Any) -> Binding | None:
    scipy = sys.modules.get("scipy._lib._ccallback")
    if scipy is None or not isinstance(given, scipy.LowLevelCallable):
        return None
    return _capsule(function, tuple.__getitem__(given, 0), keep=given)


def _capsule(function: Function, given: Any, keep: Any = None) -> Binding | None:
    """Read a capsule whose name is a signature, as Cython's and SciPy's are."""
    if type(given).__name__ != "PyCapsule":
        return None
    api = ctypes.pythonapi
    name = _api(api.PyCapsule_GetName, ctypes.c_char_p)(given)
    signature = (name or b"").decode("utf-8", "replace")
    # The same pointer is passed back, since capsules compare the text of the name.
    address = _api(api.PyCapsule_GetPointer, ctypes.c_void_p, ctypes.c_char_p)(given, name)
    user_data = _api(api.PyCapsule_GetContext, ctypes.c_void_p)(given)
    return _native(
        function, given if keep is None else keep, address or 0, signature, user_data or 0
    )


def _api(entry: Any, result: Any, *more: Any) -> Callable[..., Any]:
    """Private prototype of a function of Python's C API, since the shared one is global."""
    prototype = ctypes.PYFUNCTYPE(result, ctypes.py_object, *more)
    return prototype(ctypes.cast(entry, ctypes.c_void_p).value)  # type: ignore[arg-type]


# --- messages -------------------------------------------------------------------------------------


def _kind(given: Any) -> str:
    return f"a {type(given).__name__}" if given is not None else "None"


def _wrong(function: Function, message: str, help_: str) -> AraelError:
    return AraelError(
        Diagnostic("E0822", message, origin=function.where, help=(help_,) if help_ else ())
    )


def _unknown(name: str, known: Mapping[str, Function], layout: Layout) -> Diagnostic:
    natives = [f.name for f in known.values() if f.native]
    if name in known:
        return Diagnostic(
            "E0821",
            f"`{name}` is a formula of the model, so nothing can be bound to it",
            origin=known[name].where,
            help=(f"declare it as `extern fn {name}(...) derivs [...]`",),
        )
    near = closest(name, natives)
    notes = "native functions of the model: " + (", ".join(natives) or "none")
    return Diagnostic(
        "E0821",
        f"the model has no native function `{name}`",
        origin=layout.source,
        notes=(notes,),
        help=(f"did you mean `{near[0]}`?",) if near else (),
    )
