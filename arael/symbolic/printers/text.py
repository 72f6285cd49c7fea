"""Expressions in the notation of the arael language."""

from __future__ import annotations

from arael.runtime.machine.tape import PRIMITIVES
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import ATOM, Form, Names, Notation, call, default_name, write


def _literal(value: float) -> str:
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


_OPERATORS = {
    "select": Form("if {0} then {1} else {2}", 0, (1, 1, 0)),
    "or": Form("{0} or {1}", 2, (2, 3)),
    "and": Form("{0} and {1}", 3, (3, 4)),
    "not": Form("not {0}", 4, (4,)),
    "lt": Form("{0} < {1}", 5, (6, 6)),
    "le": Form("{0} <= {1}", 5, (6, 6)),
    "eq": Form("{0} == {1}", 5, (6, 6)),
    "ne": Form("{0} != {1}", 5, (6, 6)),
    "add": Form("{0} + {1}", 6, (6, 7)),
    "sub": Form("{0} - {1}", 6, (6, 7)),
    "mul": Form("{0} * {1}", 8, (7, 9)),
    "div": Form("{0} / {1}", 8, (7, 9)),
    "neg": Form("-{0}", 7, (8,)),
    "pow": Form("{0}^{1}", 10, (11, ATOM)),
}

TEXT = Notation(
    {name: _OPERATORS.get(name, call(name, arity)) for name, (arity, _) in PRIMITIVES.items()},
    _literal,
    7,
)


def text(g: Graph, node: int, names: Names = default_name) -> str:
    """Write `node` in the notation of the language, for people to read."""
    return write(g, node, TEXT, names)
