"""Expressions in the notation of the arael language."""

from __future__ import annotations

from arael.operations import OPERATIONS, Operation
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import Form, Names, Notation, call, default_name, write


def _literal(value: float) -> str:
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _form(one: Operation) -> Form:
    return Form(one.text, one.binding, one.operands) if one.text else call(one.name, one.arity)


TEXT = Notation({one.name: _form(one) for one in OPERATIONS.values() if one.primitive}, _literal, 7)


def text(g: Graph, node: int, names: Names = default_name) -> str:
    """Write `node` in the notation of the language, for people to read."""
    return write(g, node, TEXT, names)
