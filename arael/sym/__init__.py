"""Symbolic mathematics: formulas of the language as SymPy expressions.

    from arael import sym

    f = sym.parse("sin(x) * x + 1")   # x*sin(x) + 1, a SymPy expression
    f.diff("x")                       # x*cos(x) + sin(x)
    sym.eval(f, x=2.0)                # 2.8185948536513634

SymPy differentiates, rearranges and prints. This package has what SymPy lacks: the reader of the
language's notation, its functions with the values and derivatives of models, functions of the user,
evaluation on arrays, and C text.
"""

from __future__ import annotations

from typing import Any

from sympy import Quaternion

from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES
from arael.sym.algebra import (
    Shared,
    collect,
    cse,
    diff,
    expand,
    gradient,
    hessian,
    jacobian,
    simplify,
    subs,
)  # fmt: skip
from arael.sym.evaluation import Compiled, compiled, eval
from arael.sym.functions import operation
from arael.sym.notation import text
from arael.sym.printing import c, c_function, latex, python
from arael.sym.reading import call, parse
from arael.sym.rewriting import from_sympy, to_sympy
from arael.sym.user_functions import Function, FunctionBag, function
from arael.sym.values import Transform, free_vars, symbol, symbols, vector
from arael.symbolic.c import c_prelude
from arael.symbolic.scalars import SCALARS

__all__ = [
    "Compiled", "Function", "FunctionBag", "Shared", "Transform", "c", "c_function", "c_prelude",
    "collect", "compiled", "cse", "diff", "eval", "expand", "free_vars", "from_sympy", "function",
    "gradient", "hessian", "jacobian", "latex", "parse", "python", "quaternion", "simplify", "subs",
    "symbol", "symbols", "text", "to_sympy", "vector",
]  # fmt: skip


def quaternion(of: Any) -> Any:
    """Return the quaternion of a rotation matrix; of ``"q"`` that of ``q.w q.x q.y q.z``."""
    if isinstance(of, str):
        return Quaternion(*(symbol(f"{of}.{part}") for part in "wxyz"))
    return call("quaternion", [of])


def __getattr__(name: str) -> Any:
    """Return a function of the language, or one of its constants, by name."""
    if name in CONSTANTS:
        return operation(name)
    if name not in FUNCTIONS and name not in IDENTITIES:
        raise AttributeError(f"module 'arael.sym' has no attribute {name!r}")

    def apply(*args: Any) -> Any:
        return call(name, args)

    apply.__name__ = apply.__qualname__ = name
    known = SCALARS.get(name)
    if known is not None:
        singular = f"\nSingular points: {known.singular}." if known.singular else ""
        apply.__doc__ = f"{known.value}.\n\nDerivative: {known.derivative}.{singular}"
    elif name in FUNCTIONS:
        apply.__doc__ = f"{name} of {FUNCTIONS[name].takes}."
    return apply


def __dir__() -> list[str]:
    return sorted({*globals(), *FUNCTIONS, *CONSTANTS, *IDENTITIES})
