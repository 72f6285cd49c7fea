"""What of a constraint depends on data alone: computed once per solve, and read by its kernel."""

from __future__ import annotations

from collections.abc import Callable

from arael.check.typed import ConstraintSite
from arael.compiler.scalarise import RawInput
from arael.operations import OPERATIONS
from arael.symbolic.graph import Graph

# Hoisting may need more lane inputs than the data has scalars; beyond this many more it is not
# worth the memory traffic and only costly operations are hoisted.
EXTRA_LANES = 6
COSTLY = frozenset(one.name for one in OPERATIONS.values() if one.costly)


def hoist(
    site: ConstraintSite,
    graph: Graph,
    outputs: list[int],
    live: list[int],
    states: set[int],
    raw_keys: list[RawInput],
) -> tuple[list[int], list[int]]:
    """Nodes that depend on data alone and feed what depends on parameters.

    Returns lane inputs (one value per instance) and uniforms (functions of the root's data only).
    """
    moving = graph.depends(states)
    frontier = _frontier(graph, outputs, live, moving, lambda _: True)
    if len(frontier) > len(raw_keys) + EXTRA_LANES:
        costly = {n for n in live if graph.ops[n] in COSTLY or graph.ops[n] in graph.functions}
        below = graph.depends(costly)
        frontier = _frontier(graph, outputs, live, moving, lambda n: n in below)
    varying = graph.depends(
        {graph.input(k) for k in raw_keys if not _is_root(site, k.slot)},
    )
    frontier = _lean(graph, frontier, varying)
    lanes = [n for n in frontier if n in varying]
    uniforms = [n for n in frontier if n not in varying]
    return lanes, uniforms


def _lean(graph: Graph, frontier: list[int], varying: set[int]) -> list[int]:
    """Leave out products of other lanes: to multiply costs less than to read.

    Lanes are made in f64 and rounded to the precision of the kernel. Of rounded lanes a product is
    as good as a rounded one; a difference, such as 1 - cos t, may have nothing left.
    """
    frontier_nodes = set(frontier)
    for node in reversed(frontier):
        if node not in varying or graph.ops[node] not in ("mul", "neg"):
            continue
        operands = graph.operands(node)
        varying_operands = [n for n in operands if n in varying]
        if varying_operands and all(n in frontier_nodes for n in varying_operands):
            frontier_nodes.remove(node)
            frontier_nodes.update(
                n for n in operands if n not in varying and graph.ops[n] != "const"
            )
    return sorted(frontier_nodes)


def _frontier(
    graph: Graph,
    outputs: list[int],
    live: list[int],
    moving: set[int],
    wanted: Callable[[int], bool],
) -> list[int]:
    """Find fixed nodes read by moving ones, or results, descending where not `wanted`."""
    nodes: set[int] = set()
    seen: set[int] = set()
    waiting = list(outputs)
    for node in live:
        if node in moving and graph.ops[node] != "input":
            waiting += graph.operands(node)
    while waiting:
        node = waiting.pop()
        op = graph.ops[node]
        if op == "const" or node in moving or node in seen:
            continue
        seen.add(node)
        if op == "input" or (op != "neg" and wanted(node)):
            nodes.add(node)
        else:
            waiting += graph.operands(node)
    return sorted(nodes)


def _is_root(site: ConstraintSite, slot: int) -> bool:
    return site.slots[slot].table == ""
