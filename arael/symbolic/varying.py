"""What of a program varies, and with which seeds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from arael.symbolic.graph import Graph
from arael.symbolic.partials import arguments

Seed = TypeVar("Seed")


def varying(graph: Graph, outputs: Iterable[int], seeds: Mapping[int, object]) -> list[int]:
    """Nodes that `outputs` may vary through, down to those with seeds, in order of evaluation."""
    found = set(outputs)
    stack = list(found)
    while stack:
        node = stack.pop()
        if node in seeds:
            continue
        for operand in arguments(graph, node):
            if operand not in found:
                found.add(operand)
                stack.append(operand)
    return sorted(found)


def rank_of_seeds(seeds: Mapping[int, Mapping[Seed, int]]) -> dict[Seed, int]:
    """Give the seeds numbers, in the order in which they are first named."""
    rank: dict[Seed, int] = {}
    for tangents in seeds.values():
        for seed in tangents:
            rank.setdefault(seed, len(rank))
    return rank
