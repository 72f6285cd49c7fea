"""Multiplying out, collecting and simplifying: SymPy's part, within bounds.

Before SymPy sees an expression its size and degree are checked, since SymPy works with exact
integers and would take ``(2 * x) ^ 1000000000`` at its word.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arael.diagnostics.records import AraelError
from arael.sym.derivatives import variable
from arael.sym.errors import fail
from arael.sym.expr import Expr, postorder, size
from arael.sym.limits import MAX_ALGEBRA, MAX_DEGREE, MAX_SIMPLIFY, MAX_TERMS
from arael.sym.sympy_bridge import Bridge
from arael.sym.value import V


def expand(value: V) -> V:
    """Multiply out products and whole powers of sums.

    Raises
    ------
    AraelError
        E0653 if the expression, or what would come out, is too large.
    """
    for entry in value.entries:
        _check(entry)
        _check_terms(entry)
    return _each(value, _expanded)


def collect(value: V, *by: Expr | str) -> V:
    """Gather the terms of equal powers of the variables `by`, after multiplying out.

    Raises
    ------
    AraelError
        E0652 if one of `by` is no variable; E0653 as for `expand`.
    """
    import sympy as sp

    names = [variable(v) for v in by]
    if not names:
        fail("E0652", "there is no variable to collect by", origin="collect")

    variables = [sp.Symbol(n, real=True) for n in names]
    return _each(expand(value), lambda s: sp.collect(s, variables))


def simplify(value: V) -> V:
    """Find a shorter form with the same value over the real numbers.

    What comes out is at most as long as what went in. Removable singular points may go: ``x / x``
    is 1. SymPy does not look through ``identity``, conditions, and functions it does not know.

    Raises
    ------
    AraelError
        E0653 if the expression is too large.
    """
    import sympy as sp

    for entry in value.entries:
        _check(entry, MAX_SIMPLIFY)
    found = _each(value, lambda s: sp.simplify(s, ratio=1.0))
    pairs = zip(value.entries, found.entries, strict=True)
    return value.with_entries([b if size([b]) <= size([a]) else a for a, b in pairs])


def _expanded(expression: Any) -> Any:
    import sympy as sp

    return sp.expand(
        expression, power_base=False, power_exp=False, log=False, basic=False, trig=False
    )


def _each(value: V, work: Callable[[Any], Any]) -> V:
    """Do SymPy's `work` on each scalar; what it cannot say in our words stays as it is."""
    results = []
    for entry in value.entries:
        bridge = Bridge()
        made = work(bridge.over(entry))
        try:
            results.append(bridge.back(made))
        except AraelError:
            results.append(entry)
    return value.with_entries(results)


def _check(e: Expr, most: int = MAX_ALGEBRA) -> None:
    if size([e], most + 1) > most:
        _too_large(f"more than {most} operations")
    degree: dict[int, float] = {}
    for node in postorder([e]):
        below = [degree[id(a)] for a in node.args]
        exponent = node.args[1].value if node.op == "pow" else None
        if exponent is not None:
            degree[id(node)] = below[0] * max(1.0, abs(exponent))
        elif node.op in ("mul", "div"):
            degree[id(node)] = sum(below)
        else:
            degree[id(node)] = max([1.0, *below]) if node.op in ("add", "sub", "neg") else 1.0
        if degree[id(node)] > MAX_DEGREE:
            _too_large(f"powers beyond {MAX_DEGREE}")


def _check_terms(e: Expr) -> None:
    terms: dict[int, float] = {}
    for node in postorder([e]):
        below = [terms[id(a)] for a in node.args]
        exponent = node.args[1].value if node.op == "pow" else None
        count = 1.0
        if node.op in ("add", "sub"):
            count = sum(below)
        elif node.op == "mul":
            count = below[0] * below[1]
        elif node.op in ("neg", "div"):
            count = below[0]
        elif exponent is not None and abs(exponent).is_integer() and below[0] > 1:
            count = below[0] ** min(abs(exponent), 64.0)
            if below[0] == 2:
                count = abs(exponent) + 1
        terms[id(node)] = count
        if count > MAX_TERMS:
            _too_large(f"more than {MAX_TERMS} terms, multiplied out")


def _too_large(what: str) -> None:
    fail(
        "E0653",
        f"the expression is too large for algebra: {what}",
        origin="expression",
        help=("work on its parts; `eval` and `cse` have no such bound, `diff` a far larger one",),
    )
