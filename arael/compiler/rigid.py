"""Transforms in bodies: their rotation matrices come from the state where it holds them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeGuard

from arael.check.typed import Apply, Read, TransformType, Typed
from arael.manifolds import linear, rigid
from arael.symbolic.graph import Graph

Nodes = list[int]
Matrix = list[Nodes]


class Transforms:
    """Operations on the transforms of one constraint.

    Parameters
    ----------
    graph : where nodes go
    nodes : scalars of an expression
    cached : rotation matrix of a parameter, row by row, where the state holds it
    """

    def __init__(
        self,
        graph: Graph,
        nodes: Callable[[Typed], Nodes],
        cached: Callable[[Read], Nodes],
    ) -> None:
        self.graph = graph
        self.nodes = nodes
        self.cached = cached
        self._matrices: dict[Typed, Matrix] = {}

    def matrix(self, e: Typed) -> Matrix:
        """Rotation matrix of a transform."""
        if e not in self._matrices:
            self._matrices[e] = self._matrix(e)
        return self._matrices[e]

    def _matrix(self, e: Typed) -> Matrix:
        if isinstance(e, Read) and e.version == "trial" and e.parameter:
            return linear.matrix(self.cached(e), 3, 3)
        if _is_inverse(e):
            return linear.transpose(self.matrix(e.args[0]))
        return rigid.matrix_of(self.graph, self.nodes(e))

    def needs(self, e: Apply) -> tuple[Typed, ...]:
        """Operands of which `apply` takes the scalars, in its order."""
        first = e.args[0]
        if e.name != "mul":
            return (first,)
        return (e.args[1], first.args[0] if _is_inverse(first) else first)

    def apply(self, e: Apply) -> Nodes:
        """Result of an operation whose first operand is a transform."""
        g, first = self.graph, e.args[0]
        a = self.nodes(first)
        match e.name:
            case "translation":
                return a[:3]
            case "rotation":
                return a[3:7]
            case "tf_log":
                return rigid.log(g, a)
            case "rotation_matrix":
                return linear.flatten(self.matrix(first))
            case "matrix":
                return linear.flatten(rigid.homogeneous(g, a, self.matrix(first)))
            case "inverse":
                return rigid.inverse(g, a, self.matrix(first))
        assert e.name == "mul", e.name
        return self._product(first, e.args[1])

    def _product(self, a: Typed, b: Typed) -> Nodes:
        g, right = self.graph, self.nodes(b)
        rigid_right = isinstance(b.type, TransformType)
        if _is_inverse(a):
            # Not by way of the inverse's own translation, which would turn it there and back.
            back = a.args[0]
            left, r = self.nodes(back), self.matrix(back)
            if rigid_right:
                return rigid.between(g, left, right, r)
            return rigid.apply_inverse(g, left, r, right)
        left, r = self.nodes(a), self.matrix(a)
        if rigid_right:
            return rigid.compose(g, left, right, r)
        return rigid.apply(g, left, r, right)


def _is_inverse(e: Typed) -> TypeGuard[Apply]:
    return isinstance(e, Apply) and e.name == "inverse"
