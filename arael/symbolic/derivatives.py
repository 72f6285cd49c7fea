"""The scalar operations as SymPy functions, and their derivatives by SymPy.

This is the only table of derivatives. Most operations are SymPy's own functions. A class of our own
stands for what SymPy lacks, or differentiates otherwise than a least-squares solver needs: at kinks
and jumps SymPy gives a ``DiracDelta`` or nothing where a solver needs a number.

SymPy takes 0.25 s to import, so this module is imported where something is differentiated and
nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from typing import Any

import sympy as sp
from sympy import Expr, S, Symbol

from arael.operations import OPERATIONS
from arael.operations import Operation as Record

Maker = Callable[..., Expr]
Slope = Callable[..., Expr]

FORMAL = tuple(Symbol(name, real=True) for name in ("a", "b", "c"))
"""Operands in the formulas that `partials` gives."""

VALUE = Symbol("value", real=True)
"""Value of the operation itself in these formulas."""

_TINY = Symbol("regularisation", positive=True)

CONSTANTS: Mapping[Symbol, float] = {_TINY: 1e-12}
"""Numbers that stay symbols, so that SymPy computes with them exactly: what the ``safe_`` functions
add under roots and to denominators."""


class Operation(sp.Function):  # type: ignore[misc]
    """A function that SymPy keeps as it is; `fdiff` gives its derivatives."""

    @classmethod
    def eval(cls, *args: Expr) -> None:
        """Keep the function: operands may be anything at run time."""


def _class(name: str, *slopes: Slope) -> Any:
    """Make the class of an operation, whose derivatives are functions of value and operands."""
    members: dict[str, Any] = {"__module__": __name__}
    if slopes:
        members["fdiff"] = lambda self, argindex=1: slopes[argindex - 1](self, *self.args)
    return type(name, (Operation,), members)


# Differentiated as branches, or constant wherever they have a derivative.
lt, le, eq = _class("lt"), _class("le"), _class("eq")
either, both = _class("either"), _class("both")
minimum, maximum, select = _class("minimum"), _class("maximum"), _class("select")


class quotient(Operation):
    """``a / b`` as one operation, where SymPy would distribute a power over it."""

    def _sympystr(self, printer: Any) -> str:
        return f"({printer.doprint(self.args[0])}/{printer.doprint(self.args[1])})"

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        above, below = map(printer.doprint, self.args)
        text = rf"\left(\frac{{{above}}}{{{below}}}\right)"
        return text if exp is None else f"{text}^{{{exp}}}"


# SymPy's own power divides by ``a`` in its derivative, which is 0/0 at 0. The derivative by the
# exponent is 0 at base 0: the limit of ``x^y log x``, y > 0.
power: Any = _class(
    "power",
    lambda value, a, b: b * power(a, b - 1),
    lambda value, a, b: value * sp.log(select(eq(a, 0), 1, a)),
)

# Slope 1 in the closed interval, 0 outside; at its ends the derivative is that by ``a``.
clamp = _class(
    "clamp",
    lambda value, a, low, high: select(either(lt(high, a), lt(a, low)), S.Zero, S.One),
    lambda value, a, low, high: select(both(lt(a, low), le(low, high)), S.One, S.Zero),
    lambda value, a, low, high: select(
        either(lt(high, a), both(lt(high, low), le(a, low))), S.One, S.Zero
    ),
)


# Regularised: finite at the ends of the domain and at the origin.


def _slope_of_arc(a: Expr) -> Expr:
    """Regularised 1 / sqrt(1 - a^2), zero outside -1 .. 1."""
    return select(lt(1, sp.Abs(a)), S.Zero, 1 / sp.sqrt(maximum(1 - a * a, 0) + _TINY))


safe_sqrt = _class(
    "safe_sqrt",
    lambda value, a: select(lt(a, 0), S.Zero, 1 / (2 * sp.sqrt(maximum(a, 0) + _TINY))),
)
safe_asin = _class("safe_asin", lambda value, a: _slope_of_arc(a))
safe_acos = _class("safe_acos", lambda value, a: -_slope_of_arc(a))
safe_atan2 = _class(
    "safe_atan2",
    lambda value, a, b: b / (a**2 + b**2 + _TINY),
    lambda value, a, b: -a / (a**2 + b**2 + _TINY),
)

# Differentiated as the arc tangent, not as the polynomial that gives the value.
fast_atan = _class("fast_atan", lambda value, a: sp.atan(a).diff(a))
fast_atan2 = _class(
    "fast_atan2",
    lambda value, a, b: sp.atan2(a, b).diff(a),
    lambda value, a, b: sp.atan2(a, b).diff(b),
)


# Without ``b / b``, which is 0/0 at ``b = 0``.
starship = _class(
    "starship",
    lambda value, a, b: 1 / (1 + quotient(a, b) ** 2),
    lambda value, a, b: sp.atan(quotient(a, b)) - a / b * (1 / (1 + quotient(a, b) ** 2)),
)

log2 = _class("log2", lambda value, a: 1 / (a * sp.log(2)))
log10 = _class("log10", lambda value, a: 1 / (a * sp.log(10)))
hypot = _class("hypot", lambda value, a, b: a / value, lambda value, a, b: b / value)
expm1 = _class("expm1", lambda value, a: value + 1)
log1p = _class("log1p", lambda value, a: 1 / (1 + a))
# SymPy's derivative of its own function is ``polygamma``, which the C library lacks.
digamma = _class("digamma")
lgamma = _class("lgamma", lambda value, a: digamma(a))


def sympy_function(operation: Record) -> Maker:
    """Return the SymPy function of a record."""
    module, _, name = operation.sympy.partition(":")
    found = globals() if module == __name__ else vars(import_module(module))
    return found[name]  # type: ignore[no-any-return]


MAKERS: dict[str, Maker] = {
    **{one.name: sympy_function(one) for one in OPERATIONS.values() if one.sympy},
    "identity": lambda a: a,
}
"""Operation of a graph -> SymPy's expression of its operands."""

OPERATION_OF: Mapping[Any, str] = {
    **{
        MAKERS[one.name]: one.name
        for one in OPERATIONS.values()
        if one.sympy and one.primitive and not one.sympy.startswith("operator:")
    },
    quotient: "div",
    digamma: "digamma",
}
"""Functions that occur in derivatives -> operation of a graph."""

FUNCTION_OF: Mapping[str, Maker] = {name: func for func, name in OPERATION_OF.items()}


@cache
def partials(name: str, count: int) -> tuple[tuple[int, Any], ...]:
    """Differentiate operation `name` by its `count` operands, once for all its uses.

    Returns
    -------
    Pairs of an operand's number and the derivative by it: an expression of `FORMAL` and of `VALUE`,
    which stands for what the operation has computed already. Operands without influence on the
    derivative are left out.
    """
    value = MAKERS[name](*FORMAL[:count])
    slopes = [value.diff(operand) for operand in FORMAL[:count]]
    if name != "identity":
        slopes = [slope.subs(value, VALUE) for slope in slopes]
    return tuple((k, slope) for k, slope in enumerate(slopes) if slope != 0)
