"""Numbers of constant expressions: defaults, bounds, settings of passes.

Scalars, and vectors and matrices element by element, by the functions of `arael.symbolic`,
evaluated on numbers; products and norms are in constant_vectors.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from arael.check.constant_rotations import rotation_value
from arael.check.constant_vectors import vector_value
from arael.check.typed import Apply, Component, Invoke, Literal_, Pack, Select, Typed
from arael.check.types import size_of
from arael.check.walk import postorder
from arael.operations.numbers import outside_domain
from arael.operations.numbers import value as number
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS

Values = tuple[float, ...]
Build = Callable[..., int]


def _operation(name: str) -> Build:
    return lambda g, *args: g.op(name, *args)


BUILD: dict[str, Build] = {
    **SCALARS,
    **{name: _operation(name) for name in ("neg", "add", "sub", "and", "or", "not")},
    **{name: _operation(name) for name in ("lt", "le", "eq", "ne")},
    "gt": lambda g, x, y: g.op("lt", y, x),
    "ge": lambda g, x, y: g.op("le", y, x),
    "emul": _operation("mul"),
    "ediv": _operation("div"),
}


class NotConstant(Exception):
    """An expression has no constant value, because of `node`, for `reason`."""

    def __init__(self, node: Typed, reason: str) -> None:
        super().__init__(reason)
        self.node = node
        self.reason = reason


def evaluate(expression: Typed, data: Callable[[Typed], Values | None] = lambda _: None) -> Values:
    """Values of a constant expression, flat (matrices row by row).

    `data` gives values to the fields that are read; by default reads have no value.

    Raises
    ------
    NotConstant
        If the expression has no finite value, or uses an operation that constants do not support.
    """
    known: dict[Typed, Values] = {}
    for node in postorder([expression]):
        column = data(node)
        known[node] = _value(node, known) if column is None else column
    values = known[expression]
    if not all(map(math.isfinite, values)):
        raise NotConstant(expression, f"has no finite value{_domain(expression, known)}")
    return values


def _domain(expression: Typed, values: dict[Typed, Values]) -> str:
    """The domain of the first operation whose operands are outside of it."""
    for node in postorder([expression]):
        if isinstance(node, Apply) and all(len(values[a]) == 1 for a in node.args):
            text = outside_domain(node.name, *(values[a][0] for a in node.args))
            if text:
                return f": {text}"
    return ""


def _value(node: Typed, values: dict[Typed, Values]) -> Values:
    if isinstance(node, Literal_):
        return (node.value,)
    if isinstance(node, Pack):
        return tuple(x for item in node.items for x in values[item])
    if isinstance(node, Component):
        return (values[node.of][node.index],)
    if isinstance(node, Select):
        taken = node.then if values[node.cond][0] != 0 else node.otherwise
        return values[taken]
    if isinstance(node, Apply):
        return _applied(node, [values[a] for a in node.args])
    if isinstance(node, Invoke):
        if node.value is None:
            raise NotConstant(node, "calls native code")
        return values[node.value]
    raise NotConstant(node, "depends on the data")


def _applied(node: Apply, args: Sequence[Values]) -> Values:
    size = size_of(node.type)
    if node.name in ("identity2", "identity3"):
        n = int(node.name[-1])
        return tuple(float(i == j) for i in range(n) for j in range(n))
    name = node.name
    if name in ("mul", "div") and (len(args[0]) == 1 or len(args[1]) == 1):
        name = "e" + name
    if name not in BUILD or max(map(len, args)) != size:
        types = [a.type for a in node.args]
        result = rotation_value(name, types, args) or vector_value(name, types, args)
        if result is not None:
            return result
        raise NotConstant(node, f"uses `{node.name}`, which constants do not have")
    spread = [a if len(a) == size else a * size for a in args]
    return tuple(_scalar(BUILD[name], x) for x in zip(*spread, strict=True))


def _scalar(build: Build, args: tuple[float, ...]) -> float:
    g = Graph(simplify=False)
    keys = range(len(args))
    tape = g.tape([build(g, *(g.input(k) for k in keys))], inputs=keys)
    values: list[float] = []
    for op, operands in zip(tape.ops, tape.args, strict=True):
        if op == "input":
            values.append(args[operands[0]])
        elif op == "const":
            values.append(tape.constants[operands[0]])
        else:
            values.append(number(op, *(values[k] for k in operands)))
    return values[tape.outputs[0]]
