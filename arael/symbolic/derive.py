"""Differentiation of straight-line programs: sparse forward mode on the graph.

Derivatives become nodes of the same graph, so whatever they share with the values and with each
other is found as they are made. A chain of operations that all vary through one earlier node
carries a single factor along instead of one tangent per seed; the factor meets the tangents only
where two such chains join, or at an output.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import NamedTuple, TypeVar

from arael.symbolic.graph import Graph
from arael.symbolic.partials import arguments, branches, partials
from arael.symbolic.varying import rank_of_seeds, varying

Seed = TypeVar("Seed", bound=Hashable)
Entries = dict[Hashable, int]


class _Tangent(NamedTuple):
    """`scale` times the tangents `entries`, which belong to node `base`."""

    base: int
    scale: int
    entries: Entries


def forward(
    graph: Graph, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> list[dict[Seed, int]]:
    """Differentiate `outputs` by every seed.

    Parameters
    ----------
    graph : where `outputs` are, and where their derivatives are made
    outputs : nodes
    seeds : for a node, usually an input, its derivative by each seed, as nodes. Differentiation
        does not look behind such a node. What is absent is constant.

    Returns
    -------
    One dict per output: its derivative by each seed, as nodes, in the order in which the seeds are
    first named in `seeds`. A seed that is absent has derivative zero by structure.
    """
    outputs = list(outputs)
    rank: dict[Hashable, int] = dict(rank_of_seeds(seeds).items())
    found: dict[int, _Tangent] = {}
    one = graph.const(1.0)
    place = graph.place
    for node in varying(graph, outputs, seeds):
        graph.place = graph.place_of(node, place)
        given = seeds.get(node)
        tangent: _Tangent | None
        if given is not None:
            entries: Entries = {s: t for s, t in given.items() if graph.value(t) != 0}
            tangent = _Tangent(node, one, entries) if entries else None
        elif (branch := branches(graph, node)) is not None:
            tangent = _branch(graph, node, branch, found)
        else:
            tangent = _chain(graph, node, found)
        if tangent is not None:
            found[node] = tangent
    result: list[dict[Seed, int]] = []
    for node in outputs:
        graph.place = graph.place_of(node, place)
        entries = _entries(graph, found[node]) if node in found else {}
        ordered = sorted(entries.items(), key=lambda item: rank[item[0]])
        result.append(dict(ordered))  # type: ignore[arg-type]
    graph.place = place
    return result


def _chain(graph: Graph, node: int, found: Mapping[int, _Tangent]) -> _Tangent | None:
    """Chain rule for an operation whose operands all count."""
    if not any(operand in found for operand in arguments(graph, node)):
        return None
    weights: dict[int, int] = {}
    bases: dict[int, _Tangent] = {}
    for operand, partial in partials(graph, node):
        tangent = found.get(operand)
        if tangent is None or graph.value(partial) == 0:
            continue
        weight = graph.op("mul", partial, tangent.scale)
        if tangent.base in weights:
            weight = graph.op("add", weights[tangent.base], weight)
        weights[tangent.base], bases[tangent.base] = weight, tangent
    weights = {base: weight for base, weight in weights.items() if graph.value(weight) != 0}
    if not weights:
        return None
    if len(weights) == 1:
        ((base, weight),) = weights.items()
        return _Tangent(base, weight, bases[base].entries)
    entries: Entries = {}
    one = graph.const(1.0)
    for base, weight in weights.items():
        if weight == one and not entries:  # a sum of many terms: each has the tangents before it
            entries = dict(bases[base].entries)
            continue
        for seed, entry in bases[base].entries.items():
            term = graph.op("mul", weight, entry)
            known = entries.get(seed)
            entries[seed] = term if known is None else graph.op("add", known, term)
    return _joined(graph, node, entries)


def _branch(
    graph: Graph, node: int, branch: tuple[int, int, int], found: Mapping[int, _Tangent]
) -> _Tangent | None:
    """Tangents of the arm that is taken."""
    condition, *arms = branch
    taken, otherwise = (found.get(arm) for arm in arms)
    if taken is None and otherwise is None:
        return None
    if taken is not None and otherwise is not None and taken.base == otherwise.base:
        scale = graph.op("select", condition, taken.scale, otherwise.scale)
        return _Tangent(taken.base, scale, taken.entries)
    first = _entries(graph, taken) if taken is not None else {}
    second = _entries(graph, otherwise) if otherwise is not None else {}
    zero = graph.const(0.0)
    entries = {
        seed: graph.op("select", condition, first.get(seed, zero), second.get(seed, zero))
        for seed in {**first, **second}
    }
    return _joined(graph, node, entries)


def _entries(graph: Graph, tangent: _Tangent) -> Entries:
    """Multiply the tangents out."""
    products = {s: graph.op("mul", tangent.scale, e) for s, e in tangent.entries.items()}
    return {seed: entry for seed, entry in products.items() if graph.value(entry) != 0}


def _joined(graph: Graph, node: int, entries: Entries) -> _Tangent | None:
    entries = {seed: entry for seed, entry in entries.items() if graph.value(entry) != 0}
    return _Tangent(node, graph.const(1.0), entries) if entries else None
