"""Derivatives and algebra by SymPy: variables by name, on values of any shape, within bounds.

SymPy works with exact integers and would take ``(2 * x + 1) ^ 1000000000`` at its word, so size and
degree are checked before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import sympy as sp

from arael.check.typed import REAL
from arael.diagnostics.arguments import wrong_argument
from arael.sym.errors import fail
from arael.sym.limits import (
    MAX_ALGEBRA,
    MAX_DEGREE,
    MAX_DERIVATIVES,
    MAX_DIFFERENTIATED,
    MAX_SIMPLIFY,
    MAX_TERMS,
)
from arael.sym.notation import text
from arael.sym.rewriting import from_sympy, over_the_reals, rewritten
from arael.sym.values import (
    Value,
    as_value,
    by_variable,
    entries,
    free_vars,
    listed_variables,
    postorder,
    require_size,
    size,
    symbol,
    type_of,
    with_entries,
)


def variable(by: Any) -> Any:
    """Return the variable `by`, a symbol or its name; AraelError (E0652) if it is none."""
    if isinstance(by, str):
        return symbol(by)
    if isinstance(by, sp.Symbol):
        return by
    fail(
        "E0652",
        f"cannot differentiate by `{by}`",
        origin="diff",
        help=("differentiate by a variable, such as `x`",),
    )


def diff(value: Any, by: Any, times: int = 1) -> Value:
    """Differentiate every scalar of `value` by the variable `by`, `times` times.

    The same as SymPy's ``value.diff(by, times)``, of quaternions and transforms too, and bounded.

    Raises
    ------
    AraelError
        E0652 if `by` is no variable, or `times` is out of range; E0653 if `value` is too large.
    """
    value, by = as_value(value), variable(by)
    if not isinstance(times, int) or not 0 <= times <= MAX_DERIVATIVES:
        fail(
            "E0652",
            f"the order of a derivative is a whole number, found {times!r:.40}",
            origin="diff",
            help=(f"write a number from 0 to {MAX_DERIVATIVES}",),
        )
    for _ in range(times):
        value = with_entries(value, _derivatives(entries(value), by))
    return value


def _derivatives(scalars: Sequence[Any], by: Any) -> list[Any]:
    require_size(
        scalars,
        MAX_DIFFERENTIATED,
        "what is differentiated",
        "work out numbers with `eval`, differentiate a part, or use SymPy's own `diff`",
    )
    return [sp.S.Zero if not isinstance(s, sp.Expr) else s.diff(by) for s in scalars]


def jacobian(values: Any, by: Iterable[Any] | None = None) -> Any:
    """Matrix of derivatives: a row per scalar of `values`, a column per variable.

    Parameters
    ----------
    values : a vector, or several expressions
    by : variables; by default all, in alphabetical order

    Raises
    ------
    AraelError
        E0652 if one of `by` is no variable, or there is none.
    """
    value = as_value(values)
    given = free_vars(value) if by is None else listed_variables(by, "jacobian")
    names = [variable(v) for v in given]
    if not names:
        fail(
            "E0652",
            "there is no variable to differentiate by",
            origin="jacobian",
            help=("name variables: `jacobian(f, [x, y])`",),
        )
    columns = [_derivatives(entries(value), name) for name in names]
    return sp.ImmutableMatrix(len(columns[0]), len(columns), lambda i, j: columns[j][i])


def gradient(value: Any, by: Iterable[Any] | None = None) -> Any:
    """Derivatives of a scalar by each variable, a column; by all, in alphabetical order."""
    return jacobian([_scalar(value, "gradient")], by).T


def _scalar(value: Any, function: str) -> Value:
    value = as_value(value)
    if type_of(value) != REAL:
        raise wrong_argument(
            function, "value", "a scalar", value, "`jacobian` differentiates vectors"
        )
    return value


def hessian(value: Any, by: Iterable[Any] | None = None) -> Any:
    """Matrix of second derivatives of a scalar; by all variables, in alphabetical order."""
    value = _scalar(value, "hessian")
    names = list(free_vars(value)) if by is None else listed_variables(by, "hessian")
    return jacobian(gradient(value, names), names)


def subs(value: Any, values: Mapping[Any, Any] | None = None, /, **named: Any) -> Value:
    """Put expressions or numbers in place of variables, all at once.

    SymPy's ``value.subs`` replaces one after the other, and reads strings as Python.

    Parameters
    ----------
    value : any
    values : what replaces which variable, given by name or as a symbol; expressions may be given
        too, and are found where SymPy has them as a part
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
    value = as_value(value)
    for entry in entries(value):
        _check(entry)
        _check_terms(entry)
    return _each(value, _expanded)


def _expanded(e: Any) -> Any:
    return sp.expand(e, power_base=False, power_exp=False, log=False, basic=False, trig=False)


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
    value = as_value(value)
    for entry in entries(value):
        _check(entry, MAX_SIMPLIFY)
    return _each(value, _simplified)


def _simplified(e: Any) -> Any:
    there, back = over_the_reals(e)
    found = from_sympy(sp.simplify(there, ratio=1.0).xreplace(back))
    return found if size([found]) <= size([e]) else e


def _each(value: Value, work: Callable[[Any], Any]) -> Value:
    """Do `work` on each scalar; conditions stay as they are."""
    return with_entries(value, [work(e) if isinstance(e, sp.Expr) else e for e in entries(value)])


def _exponent(node: Any) -> float | None:
    return float(node.exp) if node.is_Pow and node.exp.is_Number and node.exp.is_finite else None


def _check(e: Any, most: int = MAX_ALGEBRA) -> None:
    if size([e]) > most:
        _too_large(f"more than {most} operations")
    degree: dict[Any, float] = {}
    for node in postorder([e]):
        below = [degree[a] for a in node.args]
        exponent = _exponent(node)
        if exponent is not None:
            degree[node] = below[0] * (exponent if exponent > 1 else max(1.0, -exponent))
        elif node.is_Mul:
            degree[node] = sum(below)
        else:
            degree[node] = max([1.0, *below]) if node.is_Add else float(bool(node.free_symbols))
        if degree[node] > MAX_DEGREE:
            _too_large(f"powers beyond {MAX_DEGREE}")


def _check_terms(e: Any) -> None:
    terms: dict[Any, float] = {}
    for node in postorder([e]):
        below = [terms[a] for a in node.args]
        exponent = _exponent(node)
        count = 1.0
        if node.is_Add:
            count = sum(below)
        elif node.is_Mul:
            for n in below:
                count *= n
        elif exponent is not None and exponent.is_integer() and below[0] > 1:
            power = min(abs(exponent), 64.0)
            count = power + 1 if below[0] == 2 else below[0] ** power
        terms[node] = count
        if count > MAX_TERMS:
            _too_large(f"more than {MAX_TERMS} terms, multiplied out")


def _too_large(what: str) -> None:
    fail(
        "E0653",
        f"the expression is too large for algebra: {what}",
        origin="expression",
        help=("work on its parts; `eval` and `cse` have no such bound, `diff` a far larger one",),
    )
