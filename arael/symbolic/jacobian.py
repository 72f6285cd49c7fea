"""The shortest program found for the derivatives of a program."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import TypeVar

from arael.symbolic.derive import forward
from arael.symbolic.elimination import eliminate
from arael.symbolic.graph import Graph

Seed = TypeVar("Seed", bound=Hashable)

# A division or a root takes the time of several products; a change of sign is free.
_COST = {"div": 4, "sqrt": 4, "neg": 0, "input": 0, "const": 0, "custom": 0}


def jacobian(
    graph: Graph, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> list[dict[Seed, int]]:
    """Differentiate `outputs` by every seed, by the method that gives the shortest program.

    Parameters and result are those of `arael.symbolic.derive.forward`, which is one of the methods
    tried; the other is `arael.symbolic.elimination.eliminate`. What the losing method made is taken
    out of the graph again. A tie goes to forward mode, so the choice is deterministic.
    """
    outputs = list(outputs)
    best = min((forward, eliminate), key=lambda method: _attempt(method, graph, outputs, seeds))
    return best(graph, outputs, seeds)


def _attempt(
    method: Callable[..., list[dict[Seed, int]]],
    graph: Graph,
    outputs: list[int],
    seeds: Mapping[int, Mapping[Seed, int]],
) -> int:
    """Cost of the program that `method` makes, which is taken out of the graph again."""
    mark = len(graph)
    rows = method(graph, outputs, seeds)
    nodes = graph.live([*outputs, *(node for row in rows for node in row.values())])
    cost = sum(_COST.get(graph.ops[node], 1) for node in nodes)
    graph.rollback(mark)
    return cost
