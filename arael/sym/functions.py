"""The functions of the table of operations as SymPy functions.

A record whose SymPy function is SymPy's own is that function, others are classes: values, LaTeX and
text in Python come from the record, derivatives from `arael.symbolic.derivatives`.

SymPy's `Abs`, `Max` and the like are not differentiated as a solver needs it: at kinks and jumps
they give a ``DiracDelta``, a ``Heaviside`` or, over complex symbols, the derivative of ``re(x)``.
The classes here have the values and derivatives of models (docs/internals/symbolic.md). They print
as in the language, evaluate numerically, and work in `sympy.lambdify`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, cast

import numpy as np
import sympy as sp
from sympy.core.relational import Relational
from sympy.printing.precedence import PRECEDENCE

from arael.operations import OPERATIONS, numbers
from arael.operations import Operation as Record
from arael.operations.constants import CONSTANTS
from arael.runtime.machine.programs import evaluate
from arael.runtime.machine.tape import Tape
from arael.sym.limits import MAX_SUPERSCRIPT
from arael.symbolic import derivatives as core
from arael.symbolic.graph import Graph, Prescribed
from arael.symbolic.scalars import SCALARS
from arael.symbolic.sharing import real
from arael.symbolic.terms import exact

Maker = Callable[..., Any]

_LARGEST = 1e15
_LONGEST = 1 << 128


class Numeric(core.Operation):
    """A function that SymPy keeps as it is, with a numeric value."""

    _imp_: Callable[..., Any]
    """Value on numbers and arrays; the name is that of SymPy, which looks for it."""

    def _numpycode(self, printer: Any) -> str:
        """Call it by name in `lambdify`, though SymPy has a function `sinc` too."""
        return f"{type(self).__name__}({', '.join(map(printer.doprint, self.args))})"

    _pythoncode = _numpycode

    def _eval_evalf(self, prec: int) -> Any:
        values = [a.evalf(prec) for a in self.args]
        if not all(v.is_Number for v in values):
            return None
        return sp.Float(float(self._imp_(*map(float, values))), prec)


class Operation(Numeric):
    """A function of the language; the name of the class is that of its record in the table."""

    @classmethod
    def _imp_(cls, *args: Any) -> Any:
        return _evaluated(cls.__name__, [np.asarray(a, float) for a in args])

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        known = OPERATIONS[type(self).__name__].latex
        if not known:
            return str(printer._print_Function(self, exp))
        raised = "" if exp is None else f"^{{{exp}}}"
        if "{0}" in known:
            text = known.format(printer.doprint(self.args[0]))
            return f"{{{text}}}{raised}" if exp else text
        return rf"{known}{raised}{{\left({', '.join(map(printer.doprint, self.args))} \right)}}"

    def _npcode(self, printer: Any) -> str:
        """Text of `arael.sym.python`; composed functions have been written out."""
        written = OPERATIONS[type(self).__name__].python_expression
        if written.endswith(")"):
            return written.format(*map(printer.doprint, self.args))
        (inner,) = (printer.parenthesize(a, PRECEDENCE["Atom"], strict=True) for a in self.args)
        return f"({written.format(inner)})"


def _evaluated(name: str, args: Sequence[Any]) -> Any:
    """Value on arrays, by the table; of a composed function by the expression machine."""
    of_arrays = OPERATIONS[name].numpy
    if of_arrays is None:
        return evaluate(_tape(name), args)[0]
    with np.errstate(all="ignore"):
        return of_arrays(*args)


@cache
def _tape(name: str) -> Tape:
    g = Graph(simplify=False)
    return g.tape([SCALARS[name](g, *map(g.input, range(SCALARS[name].arity)))])


class UserFunction(Numeric):
    """Base of the classes of user functions with derivatives of their own.

    Attributes
    ----------
    declared : the `arael.sym.Function`
    """

    declared: Any

    def fdiff(self, argindex: int = 1) -> Any:
        """Return the derivative that the function prescribes."""
        return self.declared.partials(self.args)[argindex - 1]

    @classmethod
    def _imp_(cls, *args: Any) -> Any:
        return cls.declared.evaluate(*args)


def _class(one: Record, slope: Callable[..., Any]) -> Any:
    """Make a class from its derivative: of the value, the number of an operand, the operands."""

    def fdiff(self: Any, argindex: int = 1) -> Any:
        if any(arg in (sp.nan, sp.zoo) for arg in self.args):  # which SymPy does not compare
            return sp.nan
        return slope(self, argindex, *self.args)

    return type(
        one.name, (Operation,), {"__doc__": one.value, "__module__": __name__, "fdiff": fdiff}
    )


@cache
def _slope(made: Any, count: int, argindex: int) -> Any:
    """Derivative of a class of `arael.symbolic.derivatives`, of `core.FORMAL`.

    There it is over the operations of graphs, in which a condition is a number.
    """
    slope = made(*core.FORMAL[:count]).fdiff(argindex).subs(core.CONSTANTS)
    return slope.replace(
        lambda e: e.func in core.OPERATION_OF,
        lambda e: MAKERS[core.OPERATION_OF[e.func]](*e.args),
    )


def _of_record(one: Record) -> Maker:
    """Return SymPy's function of a record, or a class with its derivatives."""
    if one.name in _SPECIAL:
        return _SPECIAL[one.name]
    if one.name in _SLOPES or one.flat:
        return cast(Maker, _class(one, _SLOPES.get(one.name, lambda *_: sp.S.Zero)))
    if not one.sympy:
        return lambda *args: written_out(one.name, *args)
    made = core.sympy_function(one)
    if not isinstance(made, type) or made.__module__.startswith("sympy."):
        return made

    def slope(value: Any, argindex: int, *args: Any) -> Any:
        found = _slope(made, len(args), argindex)
        return found.xreplace(dict(zip(core.FORMAL, args, strict=False)))

    return cast(Maker, _class(one, slope))


def number(value: float) -> Any:
    """Return a number as SymPy's: exact if it is whole or a short binary fraction."""
    found = exact(value, _LARGEST)
    return sp.Float(value) if found is None else found


def operation(name: str, *args: Any) -> Any:
    """Make an operation of the language, in bounded time.

    SymPy computes with exact numbers of any length. Here a number that has become long, or very
    large or small, goes on as a float; a number that is not real is NaN.
    """
    make = MAKERS[name]
    if args and all(_is_known(a) for a in args):
        values = [real(a) for a in args]
        value = _value(name, values)
        if not all(x == 0 or 1 / _LARGEST < abs(x) < _LARGEST for x in (value, *values)):
            return sp.S(value != 0) if name in _COMPARISONS else number(value)
    if name == "pow" and args[1].is_Rational and _is_long(args[1], MAX_SUPERSCRIPT):
        args = args[0], sp.Float(args[1], 15)
    if name in _COMPARISONS and _has_nan(args):
        return sp.true if name == "ne" else sp.false
    made = make(*args)
    if isinstance(made, sp.Expr):
        for found in (made.as_coeff_Mul()[0], made.as_coeff_Add()[0]):
            if found.is_Rational and _is_long(found, _LONGEST):
                made = made.xreplace({found: sp.Float(found, 15)})
    return made


class Formulas:
    """Takes the part of a `Graph` whose nodes are SymPy expressions.

    `arael.compiler.scalarise` and `arael.symbolic` make their formulas with it.
    """

    place: int | None = None
    const, op = staticmethod(number), staticmethod(operation)

    def value(self, node: Any) -> float | None:
        """Value of a number; None of anything else."""
        return float(node) if node.is_Number else None

    def call(self, function: Any, args: Sequence[Any], value: Any = None) -> Any:
        """Make a call of a function with prescribed derivatives."""
        if isinstance(function, Prescribed):
            return operation(function.name, *args)
        return function.sympy_class(*args)


class _WrittenOut(Formulas):
    """Writes functions with prescribed derivatives out as the formula of their value."""

    def call(self, function: Any, args: Sequence[Any], value: Any = None) -> Any:
        return value


def written_out(name: str, *args: Any) -> Any:
    """Return the formula that gives the value of a function of the language."""
    return SCALARS[name].build(cast(Graph, _WrittenOut()), *args)


_COMPARISONS = ("lt", "le", "eq", "ne")


def _has_nan(args: Sequence[Any]) -> bool:
    """Whether a comparison is with NaN, which differs from everything and is never less."""
    return any(a in (sp.nan, sp.zoo) for a in args)


def remade(node: Any, args: Sequence[Any]) -> Any:
    """Return `node` with other operands."""
    if isinstance(node, Relational) and _has_nan(args):
        return sp.true if isinstance(node, sp.Ne) else sp.false
    return node.func(*args)


def _is_known(value: Any) -> bool:
    return bool(isinstance(value, sp.Expr) and value.is_number and not value.has(UserFunction))


def _is_long(rational: Any, largest: int) -> bool:
    return bool(-largest > rational.p or rational.p > largest or rational.q > largest)


def _value(name: str, values: Sequence[float]) -> float:
    if name == "sum":
        return sum(values)
    if OPERATIONS[name].primitive:
        return numbers.value(name, *values)
    return float(_evaluated(name, values))


def condition(value: Any) -> Any:
    """`value` as a condition: a number holds if it is not zero."""
    return value if isinstance(value, sp.logic.boolalg.Boolean) else sp.Ne(value, 0)


def _of_taken(taken: Any, argindex: int) -> Any:
    """1 for the operand that is taken, the first where they tie; 0 for the other."""
    here, other = (sp.S.One, sp.S.Zero) if argindex == 1 else (sp.S.Zero, sp.S.One)
    return sp.Piecewise((here, taken), (other, True))


def _slope_of_digamma(value: Any, argindex: int, x: Any) -> Any:
    """Differentiate the series that gives the value."""
    a = sp.Dummy()
    return written_out("digamma", a).diff(a).subs(a, x)


_SLOPES: Mapping[str, Callable[..., Any]] = {
    "abs": lambda value, k, a: MAKERS["sign"](a),
    "min": lambda value, k, a, b: _of_taken(sp.Le(a, b), k),
    "max": lambda value, k, a, b: _of_taken(sp.Ge(a, b), k),
    "identity": lambda value, k, a: sp.S.One,
    "cbrt": lambda value, k, a: 1 / (3 * value**2),
    "sinc": lambda value, k, a: sp.Piecewise(
        (sp.S.Zero, sp.Eq(a, 0)), ((sp.cos(a) - value) / a, True)
    ),
    "rad_diff": lambda value, k, a, b: sp.S.One if k == 1 else sp.S.NegativeOne,
    "rad_sum": lambda value, k, a, b: sp.S.One,
    "digamma": _slope_of_digamma,
}
"""Derivatives by operand k, from 1; those of SymPy are complex, singular or lacking."""

_SPECIAL: Mapping[str, Maker] = {
    "div": lambda a, b: a * sp.oo if b == 0 else a / b,
    "pow": lambda a, b: a**b,
    "starship_gamma": lambda a: 2 * sp.sqrt(a) / sp.pi,
    "deg2rad": lambda a: a * sp.pi / 180,
    "rad2deg": lambda a: a * 180 / sp.pi,
    "lt": sp.Lt,
    "le": sp.Le,
    "eq": sp.Eq,
    "ne": sp.Ne,
    "and": lambda a, b: sp.And(condition(a), condition(b)),
    "or": lambda a, b: sp.Or(condition(a), condition(b)),
    "not": lambda a: sp.Not(condition(a)),
    "select": lambda chosen, a, b: sp.Piecewise((a, condition(chosen)), (b, True)),
}

MAKERS: Mapping[str, Maker] = {
    **{one.name: _of_record(one) for one in OPERATIONS.values()},
    "sum": lambda *terms: sp.Add(*terms),
    "pi": lambda: sp.pi,
    "e": lambda: sp.E,
    "epsilon": lambda: sp.Float(CONSTANTS["epsilon"].number),
}
"""Operation of the language -> SymPy's expression of its operands."""

OWN: Mapping[str, Any] = {
    name: made
    for name, made in MAKERS.items()
    if isinstance(made, type) and issubclass(made, Operation)
}
"""Functions of the language with a class of their own, by name."""


def __getattr__(name: str) -> Any:
    """Return a class that is made from a record; pickling looks for it."""
    if name not in OWN:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return OWN[name]
