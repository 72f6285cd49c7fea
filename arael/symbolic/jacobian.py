"""The shortest program found for the derivatives of a program."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import TypeVar

from arael.symbolic.derive import forward
from arael.symbolic.elimination import eliminate
from arael.symbolic.graph import Graph

Seed = TypeVar("Seed", bound=Hashable)

LARGEST_FOR_ELIMINATION = 4000
"""Cost of the forward program above which nothing else is tried, since it would take long."""

SEEDS_FOR_ELIMINATION = 150
"""Seeds above which nothing else is tried: elimination then takes the square of their number."""

# A division or a root takes the time of several products; a change of sign is free.
_COST = {"div": 4, "sqrt": 4, "neg": 0, "input": 0, "const": 0}


def jacobian(
    graph: Graph, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> list[dict[Seed, int]]:
    """Differentiate `outputs` by every seed, by the method that gives the shorter program.

    Parameters and result are those of `arael.symbolic.derive.forward`, which is one of the methods
    tried; the other is `arael.symbolic.elimination.eliminate`. What the losing method made is taken
    out of the graph again. A tie goes to forward mode, so the choice is deterministic.
    """
    outputs = list(outputs)
    mark = len(graph)
    rows = forward(graph, outputs, seeds)
    cost = _cost(graph, outputs, rows)
    if cost > LARGEST_FOR_ELIMINATION or len(seeds) > SEEDS_FOR_ELIMINATION:
        return rows
    graph.rollback(mark)
    rows = eliminate(graph, outputs, seeds)
    if _cost(graph, outputs, rows) < cost:
        return rows
    graph.rollback(mark)
    return forward(graph, outputs, seeds)


def _cost(graph: Graph, outputs: list[int], rows: list[dict[Seed, int]]) -> int:
    nodes = graph.live([*outputs, *(node for row in rows for node in row.values())])
    return sum(_COST.get(graph.ops[node], 1) for node in nodes if not graph.is_free(node))
