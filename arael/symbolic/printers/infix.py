"""Writing a node out in full, with as few parentheses as the notation needs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass

from arael.symbolic.graph import Graph

LARGEST_TREE = 20_000
"""Operations in the written-out expression above which printing is refused."""

ATOM = 100

Names = Callable[[Hashable], str]


@dataclass(frozen=True)
class Form:
    """How an operation is written.

    Attributes
    ----------
    template : with ``{0}``, ``{1}`` ... for the operands
    binding : how strongly the whole binds
    operands : per operand, how strongly it must bind to stand without parentheses
    """

    template: str
    binding: int = ATOM
    operands: tuple[int, ...] = (0, 0, 0)


@dataclass(frozen=True)
class Notation:
    """A way of writing expressions: the forms of the operations, and of literals."""

    forms: Mapping[str, Form]
    literal: Callable[[float], str]
    negation: int
    """How strongly a leading minus sign binds."""


def call(name: str, arity: int) -> Form:
    """Write an operation as a function call."""
    return Form(f"{name}({', '.join(f'{{{i}}}' for i in range(arity))})")


def default_name(key: Hashable) -> str:
    """Name an input by its key: tuples are joined by underscores."""
    return "_".join(map(str, key)) if isinstance(key, tuple) else str(key)


def write(g: Graph, node: int, notation: Notation, names: Names = default_name) -> str:
    """Write `node` out in full in a notation.

    Raises
    ------
    ValueError
        If that takes more than `LARGEST_TREE` operations.
    """
    size = g.tree_operations([node])
    if size > LARGEST_TREE:
        raise ValueError(
            f"the expression has {size} operations written out, more than {LARGEST_TREE}"
        )
    written: dict[int, tuple[str, int]] = {}
    for current in g.live([node]):
        name = g.ops[current]
        value = g.value(current)
        if value is not None:
            text = notation.literal(value)
            written[current] = text, notation.negation if text.startswith("-") else ATOM
        elif name == "input":
            written[current] = names(g.key(current)), ATOM
        elif g.is_free(current):
            written[current] = written[g.args[current][0]]
        elif name in g.functions:
            arguments = ", ".join(written[a][0] for a in g.args[current])
            written[current] = f"{g.functions[name].name}({arguments})", ATOM
        else:
            form = notation.forms[name]
            operands = [
                text if binding >= needed else f"({text})"
                for (text, binding), needed in zip(
                    (written[a] for a in g.args[current]), form.operands, strict=False
                )
            ]
            written[current] = form.template.format(*operands), form.binding
    return written[node][0]
