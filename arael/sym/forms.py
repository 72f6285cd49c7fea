"""What the calculator has beyond the functions of the language.

Forms take formulas where functions take values: in ``diff(f, x)`` the variable ``x`` stays a
variable, whatever its value is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from arael.sym import algebra, derivatives, printing
from arael.sym.errors import fail
from arael.sym.expr import Expr
from arael.sym.reading import Reader, Special
from arael.sym.substitution import subs
from arael.sym.value import Value
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
    known = {n: v for n, v in r.names.items() if n not in names}
    value = r.within(known, node)
    for _ in range(len(known)):
        scalars = {n: known[n] for n in value.free_vars if isinstance(known.get(n), Expr)}
        if not scalars:
            break
        value = value.subs(scalars)
    return value


def _diff(r: Reader, node: tree.Call) -> Value:
    _count(node, "diff", 2, 3, "a formula, a variable, and how many times if not once")
    name = _variable(node.args[1], "diff")
    times = 1
    if len(node.args) == 3:
        order = r.value(node.args[2])
        number = order.value if isinstance(order, Expr) else None
        if number is None or not number.is_integer():
            fail("E0652", "the order of a derivative is a whole number", node.args[2].span)
        times = int(min(max(number, -1.0), 1e6))
    return derivatives.diff(_apart(r, node.args[0], [name]), name, times)


def _jacobian(r: Reader, node: tree.Call) -> Value:
    _count(node, "jacobian", 2, 2, "a formula and a list of variables, `[x, y]`")
    listed = node.args[1]
    items = listed.items if isinstance(listed, tree.ListExpr) else (listed,)
    names = [_variable(item, "jacobian") for item in items]
    return derivatives.jacobian(_apart(r, node.args[0], names), names)


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
    new = r.value(node.args[2])
    if not isinstance(new, Expr):
        fail("E0302", f"`subs` puts in a scalar, found {new.type}", node.args[2].span)
    return subs(_apart(r, node.args[0], [name]), {name: new}, {})


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
