"""Symbolic analysis of a block pattern: the cheapest of several orderings, and its cost."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.dissection import apart, nested_dissection
from arael.runtime.linear.planning import (
    Supernodes,
    adjacency,
    find_supernodes,
    minimum_degree,
    price_of,
)

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Analysis:
    """A symbolic factor and its cost.

    Attributes
    ----------
    ordering : str
        Name of the chosen ordering.
    supernodes : Supernodes
    nnz : int
        Scalars of the factor's lower triangle, merged supernodes' explicit zeros included.
    flops : float
        Additions and multiplications of the numeric factorisation.
    milliseconds : float
        Predicted time of a refactorisation, f64, one core.
    tried : dict
        Flops of each ordering that was tried.
    scattered : float
        Columns of blocks that are added to fronts beyond the second-level cache.
    """

    ordering: str
    supernodes: Supernodes
    nnz: int
    flops: float
    milliseconds: float
    tried: dict[str, float]
    scattered: float


def natural(start: Ints, neighbours: Ints, weights: Ints) -> Ints:
    """Eliminate in the order of the entities, those coupled with nearly all others last."""
    return np.concatenate(apart(start))


ORDERINGS: dict[str, Callable[[Ints, Ints, Ints], Ints]] = {
    "natural": natural,
    "minimum_degree": minimum_degree,
    "nested_dissection": nested_dissection,
}

# The order in which they are tried; what early ones find decides which later ones are worth trying.
_AUTO = ("minimum_degree", "natural", "nested_dissection")

# The ordering that is kept with its pattern: the start of a pose graph is computed in the order of
# the solver, and `auto` compares others only if that may pay.
_SHARED = "minimum_degree"

# Nested dissection takes longer than the others, in milliseconds per neighbour of a vertex. It is
# tried only if it can save time: two fifths of the eight factorisations of a solve.
_DISSECTION = 2e-3
WINS = 3.2

# The natural order of a chain of entities fills its envelope. Where that takes so many times the
# flops of another order, its symbolic factor is not worth computing.
_FULL = 4.0

# Part of the entities that must be coupled with the one before for the envelope to fill.
_CHAIN = 0.9

# Above this fraction of coupled pairs there are no useful separators.
_CROWDED = 0.25


def analyse(
    pattern: BlockPattern,
    ordering: str = "auto",
    known: Analysis | None = None,
    price: float = math.inf,
) -> Analysis:
    """Symbolic factorisation in the named ordering, or in the cheapest of all.

    Parameters
    ----------
    pattern : BlockPattern
    ordering : str
        One of `ORDERINGS`, or ``"auto"``.
    known : Analysis, optional
        A symbolic factor in a given order, which only nested dissection may replace.
    price : float
        Milliseconds of another solver for the same system.
    """
    shared: Analysis | None = pattern.known.get(ordering)
    if shared is not None:
        return shared
    start, neighbours = adjacency(pattern)
    names = list(_AUTO) if ordering == "auto" else [ordering]
    best = known
    tried: dict[str, float] = dict(known.tried) if known else {}
    for name in names if known is None else ["nested_dissection"]:
        if name == "nested_dissection" and best:
            crowded = len(neighbours) > _CROWDED * pattern.block_count**2
            wins = WINS * min(best.milliseconds, price)
            if crowded or wins < _DISSECTION * len(neighbours):
                continue
        found = pattern.known.get(name)
        if found is None:
            # An entity without unknowns is still a vertex of the graph.
            order = ORDERINGS[name](start, neighbours, np.maximum(pattern.sizes, 1))
            if name == "natural" and best:
                full = _envelope(pattern, start, neighbours, order)
                if full > _FULL * best.flops:
                    continue
            found = _price(name, pattern, start, neighbours, order)
            if name == _SHARED:
                pattern.known[name] = found
        tried[name] = found.flops
        # Of equals the natural order.
        if (
            best is None
            or found.milliseconds < best.milliseconds
            or (name == "natural" and found.milliseconds == best.milliseconds)
        ):
            best = found
    assert best is not None
    return best if len(tried) == len(best.tried) else replace(best, tried=tried)


def _envelope(pattern: BlockPattern, start: Ints, neighbours: Ints, order: Ints) -> float:
    """Flops of an order in which the factor fills its envelope; 0 where it need not."""
    count = len(order)
    place = np.empty(count, np.int64)
    place[order] = np.arange(count)
    here = place[np.repeat(np.arange(count), np.diff(start))]
    there = place[neighbours]
    if np.count_nonzero(here == there + 1) < _CHAIN * count:
        return 0.0
    first = np.arange(count)
    np.minimum.at(first, here, there)
    # Row i of the factor reaches from `first[i]` to i: of each column the scalars below it.
    width = pattern.sizes[order].astype(np.float64)
    ends = np.bincount(first, width, count) - width
    return float((width * np.cumsum(ends) ** 2).sum())


def analyse_order(pattern: BlockPattern, name: str, order: Ints) -> Analysis:
    """Symbolic factorisation in a given order, called `name`."""
    start, neighbours = adjacency(pattern)
    return _price(name, pattern, start, neighbours, order)


def _price(
    name: str,
    pattern: BlockPattern,
    start: Ints,
    neighbours: Ints,
    order: Ints,
) -> Analysis:
    supernodes = find_supernodes(start, neighbours, pattern.sizes, order)
    nnz, flops, nanoseconds, scattered = price_of(supernodes, pattern.sizes)
    tried = {name: flops}
    return Analysis(name, supernodes, nnz, flops, 1e-6 * nanoseconds, tried, scattered)
