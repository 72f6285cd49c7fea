"""SymPy's values in the notation of the language, which `parse` reads back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import sympy as sp
from sympy.core.relational import Relational
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from arael.check.typed import MatrixType, QuaternionType, TransformType, ValueType, VectorType
from arael.sym.limits import MAX_WRITTEN_OUT
from arael.sym.values import Value, as_value, entries, require_size, size, type_of
from arael.symbolic.derivatives import OPERATION_OF


def text(value: Any) -> str:
    """Write a value in the notation of the language.

    Raises
    ------
    AraelError
        E0653 if it is too large, nothing shared.
    """
    value = as_value(value)
    require_printable(value)
    return shaped(type_of(value), [_scalar(e) for e in entries(value)])


def require_printable(value: Value) -> None:
    """Raise E0653 if a value is too large to be written out."""
    require_written(size(entries(value)))


def require_written(operations: int) -> None:
    """Raise E0653 if that many operations, nothing shared, are too many."""
    help_ = "take out what is shared first, with `cse`"
    require_size(operations, MAX_WRITTEN_OUT, "the expression, written out,", help_)


def shaped(type_: ValueType, scalars: list[str]) -> str:
    """Write the scalars of a value of type `type_`, each written already."""
    if isinstance(type_, MatrixType):
        n = type_.columns
        rows = [f"[{', '.join(scalars[i : i + n])}]" for i in range(0, len(scalars), n)]
        return f"[{', '.join(rows)}]"
    if isinstance(type_, QuaternionType):
        return f"quat({', '.join(scalars)})"
    if isinstance(type_, TransformType):
        return f"{type_}({', '.join(scalars)})"
    return f"[{', '.join(scalars)}]" if isinstance(type_, VectorType) else scalars[0]


_NAMES: Mapping[Any, str] = {
    **OPERATION_OF,
    **{sp.Max: "max", sp.Min: "min", sp.loggamma: "lgamma", sp.Heaviside: "heaviside"},
}


class _Notation(StrPrinter):  # type: ignore[misc]
    """Writes a scalar or a condition, with the operators of Python."""

    def _as_ordered_terms(self, expr: Any, order: Any = None) -> list[Any]:
        """Begin with a term that is not subtracted, if there is one."""
        terms = super()._as_ordered_terms(expr, order=order)
        first = next((t for t in terms if not t.as_coeff_Mul()[0].is_extended_negative), terms[0])
        return [first, *(t for t in terms if t is not first)]

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        if expr.exp.is_Rational and expr.exp.is_negative:
            return f"1/{self.parenthesize(1 / expr, PRECEDENCE['Mul'])}"
        return str(super()._print_Pow(expr, rational))

    def _print_Float(self, expr: Any) -> str:
        value = float(expr)
        if not math.isfinite(value):
            return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)

    def _print_Function(self, expr: Any) -> str:
        name = _NAMES.get(expr.func, expr.func.__name__)
        args = expr.args[:1] if expr.func == sp.Heaviside else expr.args
        return f"{name}({', '.join(map(self.whole, args))})"

    _print_Abs = _print_Max = _print_Min = _print_Heaviside = _print_ExpBase = _print_Function

    def _print_Relational(self, expr: Any) -> str:
        return f"{self._print(expr.lhs)} {expr.rel_op} {self._print(expr.rhs)}"

    def _print_And(self, expr: Any) -> str:
        return f" {type(expr).__name__.lower()} ".join(map(self._condition, expr.args))

    _print_Or = _print_And

    def _print_Not(self, expr: Any) -> str:
        return f"not {self._condition(expr.args[0])}"

    def _condition(self, item: Any) -> str:
        inner = self._print(item)
        return inner if isinstance(item, Relational | sp.Not) else f"({inner})"

    def _print_Piecewise(self, expr: Any) -> str:
        *arms, (last, rest) = expr.args
        found = self._print(last) if rest == sp.true else "nan"
        for value, chosen in reversed(arms):
            found = f"if {self._print(chosen)} then {self._print(value)} else {found}"
        return f"({found})"

    def whole(self, expr: Any) -> str:
        """Write what nothing binds to: a conditional has no parentheses there."""
        found = str(self._print(expr))
        return found[1:-1] if isinstance(expr, sp.Piecewise) else found


for _name, _text in {
    **{"Exp1": "e", "Infinity": "inf", "NegativeInfinity": "-inf", "ComplexInfinity": "nan"},
    **{"BooleanTrue": "true", "BooleanFalse": "false"},
}.items():
    setattr(_Notation, f"_print_{_name}", lambda self, expr, text=_text: text)


def _scalar(e: Any) -> str:
    """Write a scalar; names have no ``*`` and ``/``, so these are operators."""
    return _Notation().whole(e).replace("**", "^").replace("*", " * ").replace("/", " / ")
