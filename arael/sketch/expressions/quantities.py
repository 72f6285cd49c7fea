"""Whether the units of literals fit what an expression is for."""

from __future__ import annotations

from functools import lru_cache

from arael.diagnostics.records import AraelError, Diagnostic, Span
from arael.sketch.expressions.reading import chain, path_of, read
from arael.sketch.expressions.units import SPELLED, UNITS
from arael.syntax import tree


@lru_cache(maxsize=8192)
def quantity_of(text: str) -> str:
    """``length`` or ``angle`` if literals with units make an expression one, else empty.

    Raises
    ------
    AraelError
        E1261: a length is added to an angle.
    """
    return _quantity(read(text).node)


def require_quantity(text: str, quantity: str) -> None:
    """Refuse ``12 mm`` for an angle and ``30 deg`` for a length.

    Raises
    ------
    AraelError
        E1261 with the place in the text.
    """
    found = quantity_of(text)
    if found and quantity in ("length", "angle") and found != quantity:
        names = ", ".join(
            written for written, name in SPELLED.items() if UNITS[name].quantity == quantity
        )
        expression = read(text)
        raise AraelError(
            Diagnostic(
                "E1261",
                f"expected {_article(quantity)}, found {_article(found)}",
                Span(expression.source, 0, len(text)),
                help=(f"units of {'lengths' if quantity == 'length' else 'angles'} are {names}",),
            )
        )


def _article(quantity: str) -> str:
    return "an angle" if quantity == "angle" else "a length"


def _quantity(node: tree.Expr) -> str:
    if isinstance(node, tree.Number):
        return "" if node.unit is None else UNITS[node.unit.text].quantity
    if isinstance(node, tree.Unary):
        return _quantity(node.operand)
    if isinstance(node, tree.Binary):
        return _of_chain(node)
    if isinstance(node, tree.Conditional):
        return _quantity(node.then) or _quantity(node.otherwise)
    if isinstance(node, tree.Call) and path_of(node.func) in ("abs", "min", "max"):
        return next(filter(None, map(_quantity, node.args)), "")
    return ""


def _of_chain(node: tree.Binary) -> str:
    first, links = chain(node)
    found = _quantity(first)
    for link in links:
        other = _quantity(link.right)
        if link.op in ("+", "-"):
            if found and other and found != other:
                message = f"{_article(found)} and {_article(other)} cannot be added"
                raise AraelError(Diagnostic("E1261", message, link.span))
            found = found or other
        elif link.op == "*":
            found = "" if found and other else found or other
        else:
            found = found if link.op == "/" and not other else ""
    return found
