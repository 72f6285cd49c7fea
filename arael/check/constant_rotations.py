"""Rotations and transforms in constant expressions, by the formulas of `arael.manifolds`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from arael.check.typed import MatrixType, QuaternionType, ScalarType, ValueType, VectorType
from arael.manifolds import linear, quaternion, rotation
from arael.symbolic.graph import Graph

Values = tuple[float, ...]
Nodes = list[int]


def _grid(type_: ValueType, nodes: Nodes) -> list[Nodes]:
    assert isinstance(type_, MatrixType)
    return linear.matrix(nodes, type_.rows, type_.columns)


def _rotation_matrix(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    if isinstance(types[0], QuaternionType):
        return linear.flatten(quaternion.rotation_matrix(g, args[0]))
    if isinstance(types[0], ScalarType):
        return linear.flatten(rotation.rotation_matrix2(g, args[0][0]))
    return linear.flatten(rotation.rotation_matrix(g, args[0]))


def _quaternion(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    return list(quaternion.from_rotation_matrix(g, _grid(types[0], args[0])))


def _rigid(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    if len(args) == 1:
        rows = _grid(types[0], args[0])
        turn = quaternion.from_rotation_matrix(g, [row[:3] for row in rows[:3]])
        return [*(row[3] for row in rows[:3]), *turn]
    at = 0 if isinstance(types[0], VectorType) else 1
    turn = args[1 - at]
    if isinstance(types[1 - at], MatrixType):
        turn = _quaternion(g, types[1 - at :], args[1 - at :])
    return [*args[at], *turn, *(n for a in args[2:] for n in a)]


_OPERATIONS: dict[str, Callable[[Graph, Sequence[ValueType], Sequence[Nodes]], Nodes]] = {
    "rotation_matrix": _rotation_matrix,
    "quaternion": _quaternion,
    "transform": _rigid,
    "similarity": _rigid,
    "rotation_vector": lambda g, t, a: list(rotation.rotation_vector(g, _grid(t[0], a[0]))),
    "quat_exp": lambda g, t, a: list(quaternion.exp(g, a[0])),
    "quat_log": lambda g, t, a: list(quaternion.log(g, a[0])),
    "conj": lambda g, t, a: list(quaternion.conj(g, a[0])),
    "rotate": lambda g, t, a: list(quaternion.rotate(g, a[0], a[1])),
}


def rotation_value(name: str, types: Sequence[ValueType], args: Sequence[Values]) -> Values | None:
    """Value of an operation on rotations or transforms, flat; None for another operation."""
    operation = _OPERATIONS.get(name)
    if operation is None:
        return None
    g = Graph()
    nodes = [[g.const(x) for x in values] for values in args]
    # Operations on constants are constants.
    numbers = [g.value(node) for node in operation(g, types, nodes)]
    return tuple(math.nan if value is None else value for value in numbers)
