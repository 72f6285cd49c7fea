"""What of a program varies, through which operands, and with which seeds."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import TypeVar

from arael.operations import OPERATIONS
from arael.symbolic.graph import Graph, closure

Seed = TypeVar("Seed", bound=Hashable)

# Constant wherever they have a derivative: it is zero, also where they jump.
FLAT = frozenset(one.name for one in OPERATIONS.values() if one.flat)


def arguments(g: Graph, node: int) -> tuple[int, ...]:
    """Nodes through which `node` varies, as far as its operation determines."""
    name = g.ops[node]
    if name in ("input", "const") or name in FLAT:
        return ()
    if name == "custom":
        return g.args[node][1::2]
    if name in g.functions:
        return g.functions[name].arguments(g.args[node])
    return g.args[node][1:] if name == "select" else g.args[node]


def branches(g: Graph, node: int) -> tuple[int, int, int] | None:
    """Condition and arms of a node that takes one of two values: ``select``, ``min``, ``max``.

    Their derivative is that of the arm taken. Nothing of the other may reach it, not even
    multiplied by zero, since it may be infinite or NaN. At a tie the first argument of ``min`` and
    ``max`` is taken.
    """
    name, args = g.ops[node], g.args[node]
    if name == "select":
        return args[0], args[1], args[2]
    if name not in ("min", "max"):
        return None
    return g.op("le", *(args if name == "min" else args[::-1])), args[0], args[1]


def varying(graph: Graph, outputs: Iterable[int], seeds: Mapping[int, object]) -> list[int]:
    """Nodes that `outputs` may vary through, down to those with seeds, in order of evaluation."""
    return closure(outputs, lambda node: () if node in seeds else arguments(graph, node))


def rank_of_seeds(seeds: Mapping[int, Mapping[Seed, int]]) -> dict[Seed, int]:
    """Give the seeds numbers, in the order in which they are first named."""
    rank: dict[Seed, int] = {}
    for tangents in seeds.values():
        for seed in tangents:
            rank.setdefault(seed, len(rank))
    return rank
