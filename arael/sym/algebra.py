"""Derivatives and algebra by SymPy: variables by name, on values of any shape, within bounds.

SymPy works with exact integers and would take ``(2 * x + 1) ^ 1000000000`` at its word, so size and
degree are checked before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import sympy as sp

from arael.check.typed import REAL
from arael.diagnostics.arguments import fail, require
from arael.sym import limits
from arael.sym.notation import text
from arael.sym.rewriting import from_sympy, over_the_reals, rewritten
from arael.sym.values import (
    Value,
    as_value,
    by_variable,
    entries,
    free_vars,
    postorder,
    require_size,
    size,
    symbol,
    type_of,
    variables,
    with_entries,
)  # fmt: skip


def variable(by: Any) -> Any:
    """Return the variable `by`, a symbol or its name; AraelError (E0652) if it is none."""
    if isinstance(by, str):
        return symbol(by)
    if isinstance(by, sp.Symbol):
        return by
    help_ = ("differentiate by a variable, such as `x`",)
    fail("E0652", f"cannot differentiate by `{by}`", origin="diff", help=help_)


def diff(value: Any, by: Any, times: int = 1) -> Value:
    """Differentiate every scalar of `value` by the variable `by`, `times` times.

    The same as SymPy's ``value.diff(by, times)``, of quaternions and transforms too, and bounded.

    Raises
    ------
    AraelError
        E0652 if `by` is no variable, or `times` is out of range; E0653 if `value` is too large.
    """
    value, by = as_value(value), variable(by)
    if not isinstance(times, int) or not 0 <= times <= limits.MAX_DERIVATIVES:
        message = f"the order of a derivative is a whole number, found {times!r:.40}"
        help_ = (f"write a number from 0 to {limits.MAX_DERIVATIVES}",)
        fail("E0652", message, origin="diff", help=help_)
    for _ in range(times):
        value = with_entries(value, _derivatives(value, by))
    return value


def _derivatives(value: Value, by: Any) -> list[Any]:
    help_ = "work out numbers with `eval`, differentiate a part, or use SymPy's own `diff`"
    require_size(size(entries(value)), limits.MAX_DIFFERENTIATED, "what is differentiated", help_)
    return [e.diff(by) if isinstance(e, sp.Expr) else sp.S.Zero for e in entries(value)]


def jacobian(values: Any, by: Iterable[Any] | None = None) -> Any:
    """Matrix of derivatives: a row per scalar of `values`, a column per variable.

    `values` are a vector or several expressions; the variables `by` are all, in alphabetical order,
    if none are given.

    Raises
    ------
    AraelError
        E0652 if one of `by` is no variable, or there is none.
    """
    value = as_value(values)
    names = [variable(v) for v in variables(value, by, "jacobian")]
    if not names:
        help_ = ("name variables: `jacobian(f, [x, y])`",)
        fail("E0652", "there is no variable to differentiate by", origin="jacobian", help=help_)
    return sp.ImmutableMatrix([_derivatives(value, name) for name in names]).T


def gradient(value: Any, by: Iterable[Any] | None = None) -> Any:
    """Derivatives of a scalar by each variable, a column; by all, in alphabetical order."""
    return jacobian([_scalar(value, "gradient")], by).T


def _scalar(value: Any, function: str) -> Value:
    value = as_value(value)
    help_ = "`jacobian` differentiates vectors"
    require(type_of(value) == REAL, function, "value", "a scalar", value, help_)
    return value


def hessian(value: Any, by: Iterable[Any] | None = None) -> Any:
    """Matrix of second derivatives of a scalar; by all variables, in alphabetical order."""
    value = _scalar(value, "hessian")
    names = variables(value, by, "hessian")
    return jacobian(gradient(value, names), names)


def subs(value: Any, values: Mapping[Any, Any] | None = None, /, **named: Any) -> Value:
    """Put expressions or numbers in place of variables, all at once.

    SymPy's ``value.subs`` replaces one after the other, and reads strings as Python. Variables are
    given by name or as symbols; what is to be replaced may also be an expression that is a part of
    `value` as SymPy has it.
    """
    value = as_value(value)
    given = by_variable(values, named, "subs")
    new = {symbol(k) if isinstance(k, str) else k: as_value(v) for k, v in given.items()}
    return rewritten(value, lambda node: (lambda *_: new[node]) if node in new else None)


class Shared(NamedTuple):
    """Expressions with what they share taken out.

    Attributes
    ----------
    temporaries : pairs of a new variable and what it stands for; each may use those before it
    values : the values, over variables and temporaries
    """

    temporaries: list[tuple[Any, Any]]
    values: list[Any]

    def __str__(self) -> str:
        lines = [f"{name} = {text(value)}" for name, value in self.temporaries]
        return "\n".join([*lines, *map(text, self.values)])


def cse(values: Any, prefix: str = "t") -> Shared:
    """Take out what occurs more than once, as temporaries ``t0``, ``t1``, ...; by `sympy.cse`.

    Names that the expressions use already are passed over.
    """
    symbol(prefix)  # E0651 if no name begins like that
    wanted = [as_value(v) for v in (values if isinstance(values, (list, tuple)) else [values])]
    scalars = [e for v in wanted for e in entries(v)]
    taken = [name for v in wanted for name in free_vars(v)]
    fresh = sp.numbered_symbols(prefix, exclude=map(sp.Symbol, taken))
    found, reduced = sp.cse(scalars, symbols=fresh)
    rest = iter(reduced)
    return Shared(found, [with_entries(v, [next(rest) for _ in entries(v)]) for v in wanted])


def expand(value: Any) -> Value:
    """Multiply out products and whole powers of sums.

    Raises
    ------
    AraelError
        E0653 if the expression, or what would come out, is too large.
    """
    plain = dict.fromkeys(("power_base", "power_exp", "log", "basic", "trig"), False)
    return _each(_bounded(value, terms=True), lambda e: sp.expand(e, **plain))


def collect(value: Any, *by: Any) -> Value:
    """Gather the terms of equal powers of the variables `by`, after multiplying out.

    Raises
    ------
    AraelError
        E0652 if one of `by` is no variable; E0653 as for `expand`.
    """
    names = [variable(v) for v in by]
    if not names:
        fail("E0652", "there is no variable to collect by", origin="collect")
    return _each(expand(value), lambda e: sp.collect(e, names))


def simplify(value: Any) -> Value:
    """Find a shorter form with the same value over the real numbers.

    What comes out is at most as long as what went in. Removable singular points may go: ``x / x``
    is 1. SymPy does not look through ``identity`` and functions that it does not know.

    Raises
    ------
    AraelError
        E0653 if the expression is too large.
    """
    return _each(_bounded(value, limits.MAX_SIMPLIFY), _simplified)


def _simplified(e: Any) -> Any:
    there, back = over_the_reals(e)
    found = from_sympy(sp.simplify(there, ratio=1.0).xreplace(back))
    return found if size([found]) <= size([e]) else e


def _each(value: Value, work: Callable[[Any], Any]) -> Value:
    """Do `work` on each scalar; conditions stay as they are."""
    return with_entries(value, [work(e) if isinstance(e, sp.Expr) else e for e in entries(value)])


def _bounded(value: Any, most: int = limits.MAX_ALGEBRA, *, terms: bool = False) -> Value:
    """Return a value whose size and degree, and number of terms multiplied out, are bounded."""
    value = as_value(value)
    for root in entries(value):
        if size([root]) > most:
            _too_large(f"more than {most} operations")
        degree: dict[Any, float] = {}
        count: dict[Any, float] = {}
        for node in postorder([root]):
            degrees, counts = [degree[a] for a in node.args], [count[a] for a in node.args]
            degree[node], count[node] = float(bool(node.free_symbols)), 1.0
            if node.is_Add:
                degree[node], count[node] = max([1.0, *degrees]), sum(counts)
            elif node.is_Mul:
                degree[node], count[node] = sum(degrees), math.prod(counts)
            elif node.is_Pow and node.exp.is_Number and node.exp.is_finite:
                power = float(node.exp)
                degree[node] = degrees[0] * (power if power > 1 else max(1.0, -power))
                if power.is_integer() and counts[0] > 1:
                    times = min(abs(power), 64.0)
                    count[node] = times + 1 if counts[0] == 2 else counts[0] ** times
            if degree[node] > limits.MAX_DEGREE:
                _too_large(f"powers beyond {limits.MAX_DEGREE}")
            if terms and count[node] > limits.MAX_TERMS:
                _too_large(f"more than {limits.MAX_TERMS} terms, multiplied out")
    return value


def _too_large(what: str) -> None:
    help_ = ("work on its parts; `eval` and `cse` have no such bound, `diff` a far larger one",)
    message = f"the expression is too large for algebra: {what}"
    fail("E0653", message, origin="expression", help=help_)
