"""Values as LaTeX, Python and C."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from functools import reduce
from typing import Any, ClassVar

import sympy as sp
from sympy.printing.numpy import NumPyPrinter, SciPyPrinter

from arael.check.typed import BOOL, REAL, MatrixType, VectorType
from arael.diagnostics.arguments import require
from arael.sym.algebra import cse
from arael.sym.evaluation import Lowered, parameters
from arael.sym.notation import require_printable, require_written, shaped
from arael.sym.rewriting import over_numpy
from arael.sym.values import Value, as_value, entries, free_vars, symbol, type_of
from arael.symbolic.c import REAL_TYPES, c_prelude
from arael.symbolic.c import c as c_expression


def latex(value: Any) -> str:
    """Write a value in LaTeX's mathematics, by `sympy.latex`."""
    value = as_value(value)
    require_printable(value)
    return str(sp.latex(value))


class _NumPy(SciPyPrinter):  # type: ignore[misc]
    """Writes Python that needs `np` and `scipy.special` alone."""

    _module = "np"
    _kc: ClassVar = {name: full.replace("numpy.", "np.") for name, full in NumPyPrinter._kc.items()}
    _kf: ClassVar = {name: full.replace("numpy.", "np.") for name, full in SciPyPrinter._kf.items()}

    def _print_ComplexInfinity(self, expr: Any) -> str:
        return "np.nan"

    def _print_Max(self, expr: Any) -> str:
        call = f"np.{type(expr).__name__.lower()}imum({{}}, {{}})"
        return str(reduce(call.format, map(self._print, expr.args)))

    _print_Min = _print_Max


def python(value: Any) -> str:
    """Write a value as a Python expression over NumPy, imported as ``np``, and `scipy.special`.

    Functions of the language as in the table of operations; one that is composed of others as
    `to_sympy` writes it.
    """
    value = as_value(value)
    scalars = [_NumPy({"allow_unknown_functions": True}).doprint(e) for e in _for_code(value)]
    if type_of(value) in (REAL, BOOL):
        return str(scalars[0])
    listed = type_of(value) if isinstance(type_of(value), MatrixType) else VectorType(1)
    return f"np.array({shaped(listed, scalars)})"


def _for_code(value: Value) -> tuple[Any, ...]:
    standard = over_numpy(value)
    require_printable(standard)
    names = {sp.Symbol(n): sp.Symbol(code_name(n)) for n in free_vars(standard)}
    return tuple(e.xreplace(names) for e in entries(standard))


def c(value: Any, real: str = "double") -> str:
    """Write a value as a C expression; one of several scalars as a braced list of them.

    It may call functions that `c_prelude` defines, and native functions by their name.
    """
    require(str(real) in REAL_TYPES, "c", "real", "`double` or `float`", real)
    value = as_value(value)
    require_printable(value)
    scalars = [_c(e, real) for e in entries(value)]
    return scalars[0] if type_of(value) in (REAL, BOOL) else "{" + ", ".join(scalars) + "}"


def _c(e: Any, real: str) -> str:
    lowered = Lowered([e])
    require_written(lowered.graph.tree_operations(lowered.roots))  # composed functions included

    def name(key: Any) -> str:
        if isinstance(key, sp.Basic):  # a call of a native function
            return f"{key.declared.name}({', '.join(_c(a, real) for a in key.args)})"
        return code_name(key)

    return c_expression(lowered.graph, lowered.roots[0], name, real)


def c_function(name: str, value: Any, by: Sequence[Any] | None = None) -> str:
    """Write a C function of doubles that computes a value, shared subexpressions once.

    A scalar is returned; the scalars of anything else are written to ``out``. Its arguments are the
    variables `by`, or all in alphabetical order. The text begins with what it needs of ``math.h``
    and more.
    """
    value = as_value(value)
    symbol(name)  # E0651 if that is no name
    heads = [f"double {code_name(n)}" for n in parameters(value, by, "c_function")]
    shared = cse([value])
    (result,) = shared.values
    scalar = type_of(value) in (REAL, BOOL)
    heads += [] if scalar else ["double *out"]
    lines = [f"{'double' if scalar else 'void'} {name}({', '.join(heads) or 'void'}) {{"]
    lines += [f"    const double {t.name} = {c(e)};" for t, e in shared.temporaries]
    for i, e in enumerate(entries(result)):
        lines.append(f"    {'return' if scalar else f'out[{i}] ='} {c(e)};")
    return c_prelude() + "\n".join([*lines, "}"]) + "\n"


def code_name(key: Hashable) -> str:
    """Name of a variable in Python and C."""
    return str(key).replace(".", "_")
