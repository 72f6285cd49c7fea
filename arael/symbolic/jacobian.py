"""Derivatives of a program, as further nodes of its graph: differentiated and shared by SymPy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Literal

from arael.symbolic.graph import Graph
from arael.symbolic.varying import Seed, arguments, rank_of_seeds, varying

if TYPE_CHECKING:
    from arael.symbolic.sharing import Shared

Method = Literal["forward", "eliminate"]

LARGEST_FOR_ELIMINATION = 4000
"""Cost of the forward program above which nothing else is tried, since it would take long."""

SEEDS_FOR_ELIMINATION = 150
"""Seeds above which nothing else is tried: elimination then takes the square of their number."""

# A division or a root takes the time of several products; a change of sign is free.
_COST = {"div": 4, "sqrt": 4, "neg": 0, "input": 0, "const": 0}


def jacobian(
    graph: Graph,
    outputs: Iterable[int],
    seeds: Mapping[int, Mapping[Seed, int]],
    methods: Sequence[Method] = ("forward", "eliminate"),
) -> list[dict[Seed, int]]:
    """Differentiate `outputs` by every seed, by the method that gives the shorter program.

    Every operation is differentiated by SymPy, once for all its uses
    (`arael.symbolic.derivatives.partials`). The chain rule joins these derivatives in forward mode
    or by vertex elimination, with a symbol for every value and for every sum, so that expressions
    stay small. `sympy.cse` finds what they have in common.

    Parameters
    ----------
    graph : where `outputs` are, and where their derivatives are made
    outputs : nodes
    seeds : for a node, usually an input, its derivative by each seed, as nodes. Differentiation
        does not look behind such a node. What is absent is constant.
    methods : orders of the chain rule to try. What the longer one made is taken out of the graph
        again. A tie goes to the first.

    Returns
    -------
    One dict per output: its derivative by each seed, as nodes, in the order in which the seeds are
    first named in `seeds`. A seed that is absent has derivative zero by structure.
    """
    outputs = list(outputs)
    if not seeds or not any(seeds.values()):
        return [{} for _ in outputs]
    rows = derive(graph, outputs, seeds, methods).write()
    zero = graph.const(0.0)
    return [{seed: node for seed, node in row.items() if node != zero} for row in rows]


def derive(
    graph: Graph,
    outputs: Sequence[int],
    seeds: Mapping[int, Mapping[Seed, int]],
    methods: Sequence[Method] = ("forward", "eliminate"),
) -> Shared[Seed]:
    """Differentiate as `jacobian` does, without writing the derivatives into the graph."""
    # imported here: start-up time, since these import SymPy
    from arael.symbolic.elimination import eliminate
    from arael.symbolic.forward import forward
    from arael.symbolic.sharing import Shared
    from arael.symbolic.terms import Terms

    graph.reserve(_products(graph, outputs, seeds))
    orders = {"forward": forward, "eliminate": eliminate}
    given = [node for tangents in seeds.values() for node in tangents.values()]
    known = Terms(graph, graph.live([*outputs, *given]))
    place = graph.place

    best: Shared[Seed]
    least = math.inf
    for method in methods:
        terms = known.fresh()
        rows = orders[method](terms, outputs, seeds)
        graph.place = place
        candidate = Shared(terms, outputs, rows)
        mark = len(graph)
        cost = _cost(graph, outputs, candidate.write())
        graph.rollback(mark)
        if cost < least:
            best, least = candidate, cost
        if least > LARGEST_FOR_ELIMINATION or len(seeds) > SEEDS_FOR_ELIMINATION:
            break
    return best


def _products(graph: Graph, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]) -> int:
    """Count the products of forward mode, at most, without making them.

    A derivative may be far longer than its formula, and SymPy takes about 50 us for a product.
    """
    outputs = list(outputs)
    bit = {seed: 1 << k for k, seed in enumerate(rank_of_seeds(seeds))}
    reached: dict[int, tuple[int, int]] = {}  # node -> node whose tangents it scales, their seeds
    total = 0
    for node in varying(graph, outputs, seeds):
        if node in seeds:
            reached[node] = node, sum(bit[seed] for seed in seeds[node])
            continue
        bases = dict(reached[a] for a in arguments(graph, node) if a in reached)
        if len(bases) < 2:
            reached.update((node, item) for item in bases.items())
            total += len(bases)
            continue
        for base, mask in bases.items():
            if graph.ops[node] not in ("add", "sub") or base not in graph.args[node]:
                total += mask.bit_count()
        reached[node] = node, reduce(or_, bases.values())
    return total + sum(reached[n][1].bit_count() for n in outputs if n in reached)


def _cost(graph: Graph, outputs: Sequence[int], rows: list[dict[Seed, int]]) -> int:
    nodes = graph.live([*outputs, *(node for row in rows for node in row.values())])
    return sum(_COST.get(graph.ops[node], 1) for node in nodes if not graph.is_free(node))
