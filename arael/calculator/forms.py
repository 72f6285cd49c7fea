"""What the calculator has beyond the functions of the language.

Forms take formulas where functions take values: in ``diff(f, x)`` the variable ``x`` stays a
variable, whatever its value is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import sympy as sp

from arael.check.typed import REAL
from arael.diagnostics.arguments import fail
from arael.sym import algebra, printing
from arael.sym.notation import require_printable
from arael.sym.reading import Reader, Special
from arael.sym.values import Value, free_vars, type_of
from arael.syntax import tree


def _variable(node: tree.Expr, form: str) -> str:
    text = node.span.text.replace(" ", "")
    if isinstance(node, (tree.Name, tree.Attribute)) and "(" not in text:
        return text
    fail(
        "E0652",
        f"cannot {form} by `{node.span.text[:40]}`",
        node.span,
        "expected a variable",
        help=(f"write it like `{form}(x^2, x)`",),
    )


def _count(node: tree.Call, name: str, least: int, most: int, takes: str) -> None:
    if not least <= len(node.args) <= most:
        fail(
            "E0303",
            f"`{name}` takes {takes}, found {len(node.args)}",
            node.span,
            "in this call",
        )


def _apart(r: Reader, node: tree.Expr, names: list[str]) -> Value:
    """Value of `node` with `names` as variables, and other variables put in place."""
    before = r.names
    r.names = known = {n: v for n, v in before.items() if n not in names}
    try:
        value = r.read(node)
    finally:
        r.names = before
    return resolved(value, known)


def resolved(value: Value, variables: Mapping[str, Value]) -> Value:
    """Put scalar variables in place, and what they are made of, until none is left."""
    for _ in range(len(variables) + 1):
        known = {n: variables[n] for n in free_vars(value) if n in variables}
        known = {n: v for n, v in known.items() if type_of(v) == REAL}
        if not known:
            break
        require_printable(value)
        value = algebra.subs(value, known)
    return value


def _diff(r: Reader, node: tree.Call) -> Value:
    _count(node, "diff", 2, 3, "a formula, a variable, and how many times if not once")
    name = _variable(node.args[1], "diff")
    times = 1
    if len(node.args) == 3:
        order = r.read(node.args[2])
        if not isinstance(order, sp.Integer):
            fail("E0652", "the order of a derivative is a whole number", node.args[2].span)
        times = int(order)
    return algebra.diff(_apart(r, node.args[0], [name]), name, times)


def _jacobian(r: Reader, node: tree.Call) -> Value:
    _count(node, "jacobian", 2, 2, "a formula and a list of variables, `[x, y]`")
    listed = node.args[1]
    items = listed.items if isinstance(listed, tree.ListExpr) else (listed,)
    names = [_variable(item, "jacobian") for item in items]
    return algebra.jacobian(_apart(r, node.args[0], names), names)


def _expand(r: Reader, node: tree.Call) -> Value:
    _count(node, "expand", 1, 1, "a formula")
    return algebra.expand(_apart(r, node.args[0], []))


def _simplify(r: Reader, node: tree.Call) -> Value:
    _count(node, "simplify", 1, 1, "a formula")
    return algebra.simplify(_apart(r, node.args[0], []))


def _collect(r: Reader, node: tree.Call) -> Value:
    _count(node, "collect", 2, 2, "a formula and a variable")
    name = _variable(node.args[1], "collect")
    return algebra.collect(_apart(r, node.args[0], [name]), name)


def _subs(r: Reader, node: tree.Call) -> Value:
    _count(node, "subs", 3, 3, "a formula, a variable, and what to put in its place")
    name = _variable(node.args[1], "subs")
    new = r.read(node.args[2])
    if type_of(new) != REAL:
        fail("E0302", f"`subs` puts in a scalar, found {type_of(new)}", node.args[2].span)
    return algebra.subs(_apart(r, node.args[0], [name]), {name: new})


FORMS: Mapping[str, Special] = {
    "diff": _diff,
    "jacobian": _jacobian,
    "expand": _expand,
    "collect": _collect,
    "simplify": _simplify,
    "subs": _subs,
}

TEXTS: Mapping[str, Callable[[Value], str]] = {
    "latex": printing.latex,
    "python": printing.python,
    "c": printing.c,
}
