"""SymPy's counterparts of what the language has beyond elementary functions.

SymPy is imported here at once; import this module where it is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import sympy as sp

from arael.sym.derivatives import written_out
from arael.sym.expr import Expr


class floor(sp.floor):  # type: ignore[misc]
    """SymPy's `floor` with the derivative 0 that models use; SymPy leaves it unevaluated."""

    def fdiff(self, argindex: int = 1) -> Any:
        """Return the derivative by the argument."""
        return sp.S.Zero


class ceiling(sp.ceiling):  # type: ignore[misc]
    """SymPy's `ceiling`, in the same way."""

    def fdiff(self, argindex: int = 1) -> Any:
        """Return the derivative by the argument."""
        return sp.S.Zero


_HALF = sp.Rational(1, 2)


def _cbrt(a: Any) -> Any:
    """Real cube root; piecewise, so that its derivative has no `DiracDelta`."""
    root = sp.Abs(a) ** sp.Rational(1, 3)
    return sp.Piecewise((root, a >= 0), (-root, True))


def _condition(value: Any) -> Any:
    return value if isinstance(value, sp.logic.boolalg.Boolean) else sp.Ne(value, 0)


def _safe_asin(a: Any) -> Any:
    return sp.Piecewise((sp.asin(a), sp.Abs(a) < 1), (sp.sign(a) * sp.pi / 2, True))


OPERATIONS: dict[str, Callable[..., Any]] = {
    "cbrt": _cbrt,
    "log2": lambda a: sp.log(a, 2),
    "log10": lambda a: sp.log(a, 10),
    # Piecewise, since the derivative of sqrt(Max(0, a)) would be 0 * oo below 0.
    "safe_sqrt": lambda a: sp.Piecewise((sp.sqrt(a), a > 0), (0, True)),
    "safe_asin": _safe_asin,
    "safe_acos": lambda a: sp.pi / 2 - _safe_asin(a),
    "safe_atan2": lambda y, x: sp.Piecewise((sp.atan2(y, x), x**2 + y**2 > 0), (0, True)),
    "sign": sp.sign,
    "heaviside": lambda a: sp.Heaviside(a, _HALF),
    "floor": floor,
    "ceil": ceiling,
    "round": lambda a: sp.sign(a) * floor(sp.Abs(a) + _HALF),
    "min": sp.Min,
    "max": sp.Max,
    "identity": lambda a: a,
    "lt": sp.Lt,
    "le": sp.Le,
    "eq": sp.Eq,
    "ne": sp.Ne,
    "and": lambda a, b: sp.And(_condition(a), _condition(b)),
    "or": lambda a, b: sp.Or(_condition(a), _condition(b)),
    "not": lambda a: sp.Not(_condition(a)),
    "select": lambda c, a, b: sp.Piecewise((a, _condition(c)), (b, True)),
}


def written(name: str, args: list[Any], over: Callable[[Expr], Any]) -> Any:
    """Write out a function of the language, such as ``safe_sqrt``, for SymPy arguments.

    `over` takes expressions over to SymPy.
    """
    formal, formula = _formula(name, len(args), over)
    return formula.xreplace(dict(zip(formal, args, strict=True)))


@cache
def _formula(name: str, arity: int, over: Callable[[Expr], Any]) -> tuple[tuple[Any, ...], Any]:
    names = [f"{name}.{i}" for i in range(arity)]
    formal = tuple(sp.Symbol(n, real=True) for n in names)
    return formal, over(written_out(name, *(Expr("symbol", (), n) for n in names)))
