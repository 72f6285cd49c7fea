"""Dotted names of expressions: ``L0.length`` for the length of a line that a program calls L0.

The part before a dot is reserved for such names. If it were also a field of the model, a parameter
or another expression, ``L0.length`` would be ambiguous in formulas, so the definition is an error.
"""

from __future__ import annotations

from collections.abc import Iterable

from arael.residuals.messages import label_problem, name_problem
from arael.syntax import tables, tree


def dotted_problem(name: object) -> str:
    """Why `name` cannot name an expression; "" if it can."""
    if not isinstance(name, str) or "." not in name:
        return name_problem(name)
    if len(name) > 100:
        return "it has more than 100 characters"
    first, *others = name.split(".")
    if any(label_problem(part) for part in (first, *others)):
        return "a name is made of letters, digits and `_`, in parts joined by single dots"
    problem = name_problem(first)
    if problem:
        return f"`{first}` {problem.removeprefix('it ')}"
    words = [part for part in others if part in tables.load().words]
    return f"`{words[0]}` is a word of the language" if words else ""


def dotted_text(node: tree.Expr) -> str:
    """``L0.length`` of an expression of names joined by dots; "" of other expressions."""
    parts: list[str] = []
    while isinstance(node, tree.Attribute):
        parts.append(node.name)
        node = node.obj
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, tree.Name) else ""


def within(first: str, names: Iterable[str]) -> list[str]:
    """Those of `names` that begin with `first` and a dot."""
    return [name for name in names if name.startswith(f"{first}.")]


def clash(
    name: str, fields: Iterable[str], parameters: Iterable[str], others: Iterable[str]
) -> str:
    """The other meaning of `name`; "" if it is unambiguous.

    Parameters
    ----------
    fields : of the model's root, and its constants
    parameters : of runtime residuals
    others : names of expressions
    """
    longer = within(name, others)
    if longer:
        return f"an expression is named `{longer[0]}`"
    parts = name.split(".")
    if parts[0] in fields:
        return f"`{parts[0]}` belongs to the model"
    if len(parts) == 1:
        return ""
    if parts[0] in parameters:
        return f"`{parts[0]}` is a parameter"
    known = set(others)
    for count in range(1, len(parts)):
        shorter = ".".join(parts[:count])
        if shorter in known:
            return f"`{shorter}` is an expression"
    return ""
