"""SymPy's values in the notation of the language, which `parse` reads back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import sympy as sp
from sympy.core.relational import Relational
from sympy.printing.precedence import PRECEDENCE, precedence
from sympy.printing.str import StrPrinter

from arael.check.typed import MatrixType, QuaternionType, TransformType, ValueType, VectorType
from arael.sym.limits import MAX_WRITTEN_OUT
from arael.sym.values import Value, as_value, entries, require_size, type_of
from arael.symbolic.functions import OPERATION_OF


def text(value: Any) -> str:
    """Write a value in the notation of the language.

    Raises
    ------
    AraelError
        E0653 if it is too large, nothing shared.
    """
    value = as_value(value)
    require_printable(value)
    return shaped(type_of(value), [_PRINTER.doprint(e) for e in entries(value)])


def require_printable(value: Value) -> None:
    """Raise E0653 if a value is too large to be written out."""
    require_size(
        entries(value),
        MAX_WRITTEN_OUT,
        "the expression, written out,",
        "take out what is shared first, with `cse`",
    )


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
    """Writes a scalar or a condition."""

    def parenthesize(self, item: Any, level: int, strict: bool = False) -> str:
        """Write an operand; a conditional and a condition always in parentheses."""
        if isinstance(item, sp.Piecewise | Relational):
            return f"({self._print(item)})"
        return str(super().parenthesize(item, level, strict))

    def _print_Add(self, expr: Any, order: Any = None) -> str:
        terms = self._as_ordered_terms(expr, order=order)
        first = next((t for t in terms if not _is_negative(t)), terms[0])
        terms = [first, *(t for t in terms if t is not first)]
        found = self._term(first)
        for term in terms[1:]:
            minus = _is_negative(term)
            found += f" - {self._term(-term)}" if minus else f" + {self._term(term)}"
        return found

    def _term(self, term: Any) -> str:
        return self.parenthesize(term, PRECEDENCE["Add"], strict=not term.is_Add)

    def _print_Mul(self, expr: Any) -> str:
        if _is_negative(expr):
            return f"-{self.parenthesize(-expr, precedence(expr))}"
        above: list[Any] = []
        below: list[Any] = []
        for factor in expr.as_ordered_factors():
            if factor.is_Rational and factor.q != 1:
                above += [sp.Integer(factor.p)] * (factor.p != 1)
                below.append(sp.Integer(factor.q))
            elif _is_reciprocal(factor):
                below.append(1 / factor)
            else:
                above.append(factor)
        numerator = self._factors(above) or "1"
        if not below:
            return numerator
        denominator = self._factors(below)
        return f"{numerator} / {denominator if len(below) == 1 else f'({denominator})'}"

    def _factors(self, factors: list[Any]) -> str:
        level = PRECEDENCE["Mul"]
        return " * ".join(self.parenthesize(f, level) for f in factors)

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        base, exponent = expr.args
        if _is_reciprocal(expr):
            below = 1 / expr
            return f"1 / {self.parenthesize(below, PRECEDENCE['Mul'])}"
        if exponent == sp.S.Half:
            return f"sqrt({self._print(base)})"
        level = PRECEDENCE["Pow"]
        raised = self._print(exponent)
        if not (exponent.is_Symbol or (exponent.is_Number and raised.replace(".", "").isalnum())):
            raised = f"({raised})"
        return f"{self.parenthesize(base, level)}^{raised}"

    def _print_Rational(self, expr: Any) -> str:
        return str(expr.p) if expr.q == 1 else f"{expr.p} / {expr.q}"

    def _print_Float(self, expr: Any) -> str:
        value = float(expr)
        if not math.isfinite(value):
            return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)

    def _print_Function(self, expr: Any) -> str:
        name = _NAMES.get(expr.func, expr.func.__name__)
        args = expr.args[:1] if expr.func == sp.Heaviside else expr.args
        return f"{name}({', '.join(map(self._print, args))})"

    _print_Abs = _print_Max = _print_Min = _print_Heaviside = _print_ExpBase = _print_Function

    def _print_Relational(self, expr: Any) -> str:
        level = precedence(expr)
        a, b = (self.parenthesize(x, level) for x in expr.args)
        return f"{a} {expr.rel_op} {b}"

    def _print_And(self, expr: Any) -> str:
        return " and ".join(self._condition(a) for a in expr.args)

    def _print_Or(self, expr: Any) -> str:
        return " or ".join(self._condition(a) for a in expr.args)

    def _print_Not(self, expr: Any) -> str:
        return f"not {self._condition(expr.args[0])}"

    def _condition(self, item: Any) -> str:
        inner = self._print(item)
        return inner if isinstance(item, Relational | sp.Not) else f"({inner})"

    def _print_Piecewise(self, expr: Any) -> str:
        *arms, (last, rest) = expr.args
        found = self._print(last) if rest == sp.true else "nan"
        for value, chosen in reversed(arms):
            found = f"if {self._print(chosen)} then {self._arm(value)} else {found}"
        return found

    def _arm(self, value: Any) -> str:
        return f"({self._print(value)})" if value.has(sp.Piecewise) else str(self._print(value))


for _name, _text in {
    **{"Exp1": "e", "Infinity": "inf", "NegativeInfinity": "-inf", "ComplexInfinity": "nan"},
    **{"BooleanTrue": "true", "BooleanFalse": "false"},
}.items():
    setattr(_Notation, f"_print_{_name}", lambda self, expr, text=_text: text)


def _is_negative(term: Any) -> bool:
    return bool(term.as_coeff_Mul()[0].is_extended_negative)


def _is_reciprocal(factor: Any) -> bool:
    return bool(factor.is_Pow and factor.exp.is_Rational and factor.exp.is_negative)


_PRINTER = _Notation()
