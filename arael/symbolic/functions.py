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

from arael.runtime.machine.library import FUNCTIONS, LibraryFunction
from arael.symbolic.scalars.function import REGULARISATION

FORMAL = tuple(Symbol(name, real=True) for name in ("a", "b", "c"))
"""Operands in the formulas that `partials` gives."""

VALUE = Symbol("value", real=True)
"""Value of the operation itself in these formulas."""

_TINY = Symbol("regularisation", positive=True)

CONSTANTS: Mapping[Symbol, float] = {_TINY: REGULARISATION}
"""Numbers that stay symbols, so that SymPy computes with them exactly."""


class Operation(sp.Function):  # type: ignore[misc]
    """A function that SymPy keeps as it is; `fdiff` gives its derivatives."""

    @classmethod
    def eval(cls, *args: Expr) -> None:
        """Keep the function: operands may be anything at run time."""


class lt(Operation):
    """``a < b``, as 1 or 0."""


class le(Operation):
    """``a <= b``, as 1 or 0."""


class eq(Operation):
    """``a == b``, as 1 or 0."""


class either(Operation):
    """``a or b`` of conditions."""


class both(Operation):
    """``a and b`` of conditions."""


class minimum(Operation):
    """The smaller operand; differentiated as a branch."""


class maximum(Operation):
    """The larger operand; differentiated as a branch."""


class select(Operation):
    """``a != 0 ? b : c``; differentiated as a branch."""


class quotient(Operation):
    """``a / b`` as one operation, where SymPy would distribute a power over it."""

    def _sympystr(self, printer: Any) -> str:
        return f"({printer.doprint(self.args[0])}/{printer.doprint(self.args[1])})"

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        above, below = map(printer.doprint, self.args)
        text = rf"\left(\frac{{{above}}}{{{below}}}\right)"
        return text if exp is None else f"{text}^{{{exp}}}"


class power(Operation):
    """``a^b``. SymPy's own power divides by ``a`` in its derivative, which is 0/0 at 0."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Make the derivative by the exponent 0 at base 0: the limit of ``x^y log x``, y > 0."""
        a, b = self.args
        if argindex == 1:
            return b * power(a, b - 1)
        return self * sp.log(select(eq(a, 0), 1, a))


class clamp(Operation):
    """``a`` held in ``b .. c``: slope 1 in the closed interval, 0 outside."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """At the ends of the interval the derivative is that by ``a``."""
        a, low, high = self.args
        over, under = lt(high, a), lt(a, low)
        if argindex == 1:
            return select(either(over, under), S.Zero, S.One)
        if argindex == 2:
            return select(both(under, le(low, high)), S.One, S.Zero)
        return select(either(over, both(lt(high, low), le(a, low))), S.One, S.Zero)


class safe_sqrt(Operation):
    """``sqrt(max(a, 0))``."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Regularised: finite at 0."""
        (a,) = self.args
        return select(lt(a, 0), S.Zero, 1 / (2 * sp.sqrt(maximum(a, 0) + _TINY)))


def _slope_of_arc(a: Expr) -> Expr:
    """Regularised 1 / sqrt(1 - a^2), zero outside -1 .. 1."""
    return select(lt(1, sp.Abs(a)), S.Zero, 1 / sp.sqrt(maximum(1 - a * a, 0) + _TINY))


class safe_asin(Operation):
    """``asin`` of ``a`` held in -1 .. 1."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Regularised: finite at -1 and 1."""
        return _slope_of_arc(self.args[0])


class safe_acos(Operation):
    """``acos`` of ``a`` held in -1 .. 1."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Regularised: finite at -1 and 1."""
        return -_slope_of_arc(self.args[0])


class safe_atan2(Operation):
    """``atan2``."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Regularised: 0 at the origin."""
        a, b = self.args
        squares = a**2 + b**2 + _TINY
        return b / squares if argindex == 1 else -a / squares


class fast_atan(Operation):
    """``atan`` by a polynomial."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate the arc tangent, not the polynomial."""
        return sp.atan(self.args[0]).diff(self.args[0])


class fast_atan2(Operation):
    """``atan2`` by a polynomial."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate the arc tangent, not the polynomial."""
        return sp.atan2(*self.args).diff(self.args[argindex - 1])


class starship(Operation):
    """``b atan(a / b)``."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Without ``b / b``, which is 0/0 at ``b = 0``."""
        a, b = self.args
        ratio = quotient(a, b)
        slope = 1 / (1 + ratio**2)
        return slope if argindex == 1 else sp.atan(ratio) - a / b * slope


class log2(Operation):
    """Logarithm to base 2."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """1 / (a ln 2)."""
        return 1 / (self.args[0] * sp.log(2))


class log10(Operation):
    """Logarithm to base 10."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """1 / (a ln 10)."""
        return 1 / (self.args[0] * sp.log(10))


class hypot(Operation):
    """``sqrt(a^2 + b^2)`` without overflow."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Share of the operand in the value."""
        return self.args[argindex - 1] / self


class expm1(Operation):
    """``exp(a) - 1`` without cancellation near 0."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """By the value itself: `exp` needs no call of its own."""
        return self + 1


class log1p(Operation):
    """``log(1 + a)`` without cancellation near 0."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """1 / (1 + a)."""
        return 1 / (1 + self.args[0])


class digamma(Operation):
    """Derivative of `lgamma`."""


class lgamma(Operation):
    """``log |gamma(a)|``."""

    def fdiff(self, argindex: int = 1) -> Expr:
        """SymPy's is ``polygamma``, which the C library lacks."""
        return digamma(self.args[0])


Maker = Callable[..., Expr]


def sympy_function(function: LibraryFunction) -> Maker:
    """Return the SymPy function of a record."""
    module, _, name = function.sympy.partition(":")
    found = globals() if module == __name__ else vars(import_module(module))
    return found[name]  # type: ignore[no-any-return]


MAKERS: dict[str, Maker] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "identity": lambda a: a,
    **{f.name: sympy_function(f) for f in FUNCTIONS},
    "abs": sp.Abs,
    "clamp": clamp,
    "safe_sqrt": safe_sqrt,
    "safe_asin": safe_asin,
    "safe_acos": safe_acos,
    "safe_atan2": safe_atan2,
    "fast_atan": fast_atan,
    "fast_atan2": fast_atan2,
    "starship": starship,
}
"""Operation of a graph -> SymPy's expression of its operands."""

OPERATION_OF: Mapping[Any, str] = {
    **{MAKERS[f.name]: f.name for f in FUNCTIONS},
    sp.sign: "sign",
    sp.Abs: "abs",
    quotient: "div",
    minimum: "min",
    maximum: "max",
    select: "select",
    lt: "lt",
    le: "le",
    eq: "eq",
    either: "or",
    both: "and",
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
    operands = FORMAL[:count]
    value = MAKERS[name](*operands)
    found = []
    for k, operand in enumerate(operands):
        slope = value.diff(operand)
        if name != "identity":
            slope = slope.subs(value, VALUE)
        if slope != 0:
            found.append((k, slope))
    return tuple(found)
