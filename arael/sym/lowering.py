"""From expressions to graphs, which are evaluated and printed as programs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from arael.sym.errors import fail
from arael.sym.expr import Expr, postorder, remake
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS

if TYPE_CHECKING:
    from arael.sym.user_functions import Function

_MAX_NODES = 1_000_000


@dataclass
class Lowered:
    """A graph, the nodes of expressions in it, and the native calls that are inputs of it.

    The inputs are keyed by name for variables, and by the expression for calls of native functions.
    """

    graph: Graph
    nodes: list[int] = field(default_factory=list)
    calls: list[Expr] = field(default_factory=list)


def lower(roots: Iterable[Expr], *, simplify: bool = True) -> Lowered:
    """Make a graph of `roots`. Functions with a formula are written out; native ones are inputs."""
    roots = formulas(roots)
    result = Lowered(Graph(simplify=simplify))
    g = result.graph
    made: dict[int, int] = {}
    seen: set[Expr] = set()
    for node in postorder(roots):
        args = [made[id(a)] for a in node.args]
        if node.op == "const":
            at = g.const(node.data)
        elif node.op == "symbol":
            at = g.input(node.data)
        elif node.op == "call":
            at = g.input(node)
            if node not in seen:
                seen.add(node)
                result.calls.append(node)
        elif node.op in SCALARS:
            at = SCALARS[node.op](g, *args)
        else:
            at = g.op(node.op, *args)
        made[id(node)] = at
        if len(g) > _MAX_NODES:
            fail("E0653", f"more than {_MAX_NODES} operations", origin="expression")
    result.nodes = [made[id(root)] for root in roots]
    return result


def formulas(roots: Iterable[Expr], trail: tuple[Function, ...] = ()) -> list[Expr]:
    """Write out the calls of functions that have a formula, keeping those of native ones.

    Raises
    ------
    AraelError
        E0605 if a formula calls the function whose formula it is.
    """
    from arael.sym.user_functions import recursion

    roots = list(roots)
    new: dict[int, Expr] = {}
    for node in postorder(roots):
        args = tuple(new[id(a)] for a in node.args)
        if node.op == "call" and not node.data.is_native:
            function: Function = node.data
            if function in trail:
                raise recursion([f.name for f in trail], function.name, function)
            (new[id(node)],) = formulas([function.formula(args)], (*trail, function))
        elif all(a is b for a, b in zip(args, node.args, strict=True)):
            new[id(node)] = node
        else:
            new[id(node)] = remake(node, args)
    return [new[id(root)] for root in roots]
