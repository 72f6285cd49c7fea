"""Nodes of a graph with Python's operators, for formulas that read as such."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from arael.symbolic.graph import Graph


def _operator(name: str, *, reflected: bool = False) -> Callable[..., Scalar]:
    def apply(self: Scalar, *others: Scalar | float) -> Scalar:
        g = self.graph
        nodes = [o.node if isinstance(o, Scalar) else g.const(o) for o in (self, *others)]
        return Scalar(g, g.op(name, *(reversed(nodes) if reflected else nodes)))

    return apply


@dataclass(frozen=True)
class Scalar:
    """A node; ``x.sin()``, ``x.max(0)`` and ``(x < 0).select(a, b)`` are other operations of it."""

    graph: Graph
    node: int

    __add__ = __radd__ = _operator("add")
    __mul__ = __rmul__ = _operator("mul")
    __sub__, __rsub__ = _operator("sub"), _operator("sub", reflected=True)
    __truediv__, __rtruediv__ = _operator("div"), _operator("div", reflected=True)
    __lt__, __gt__ = _operator("lt"), _operator("lt", reflected=True)
    __neg__ = _operator("neg")

    def __getattr__(self, name: str) -> Callable[..., Scalar]:
        """Return the operation `name` of this node and others."""
        return lambda *others: _operator(name)(self, *others)
