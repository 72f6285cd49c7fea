"""Forward mode over definitions: each carries its derivative by every seed along.

A chain of definitions that all vary through one earlier one carries a single factor instead of one
tangent per seed. The factor is multiplied with the tangents only where two such chains join, or at
an output.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import NamedTuple

from sympy import Add, S

from arael.symbolic.derivatives import select
from arael.symbolic.terms import Term, Terms
from arael.symbolic.varying import Seed, arguments, branches, rank_of_seeds, varying

Entries = dict[Hashable, Term]


class _Tangent(NamedTuple):
    """`scale` times the tangents `entries`, which belong to node `base`."""

    base: int
    scale: Term
    entries: Entries


def forward(
    terms: Terms, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> list[dict[Seed, Term]]:
    """Differentiate `outputs` by every seed.

    Parameters and result are those of `arael.symbolic.jacobian.jacobian`, with terms for nodes.
    """
    outputs = list(outputs)
    graph = terms.graph
    rank = rank_of_seeds(seeds)
    found: dict[int, _Tangent] = {}
    for node in varying(graph, outputs, seeds):
        terms.at(node)
        given = seeds.get(node)
        tangent: _Tangent | None
        if given is not None:
            tangent = _joined(node, {s: terms.leaf(t) for s, t in given.items()})
        elif (branch := branches(graph, node)) is not None:
            tangent = _branch(terms, node, branch, found)
        else:
            tangent = _chain(terms, node, found)
        if tangent is not None:
            found[node] = tangent
    result: list[dict[Seed, Term]] = []
    for node in outputs:
        terms.at(node)
        entries = _entries(terms, found.get(node))
        result.append({s: terms.atom(entries[s]) for s in rank if s in entries})
    return result


def _chain(terms: Terms, node: int, found: Mapping[int, _Tangent]) -> _Tangent | None:
    """Chain rule for an operation whose operands all count."""
    if not any(operand in found for operand in arguments(terms.graph, node)):
        return None
    weights: dict[int, Term] = {}
    bases: dict[int, _Tangent] = {}
    for operand, partial in terms.partials(node):
        tangent = found.get(operand)
        if tangent is not None:
            weight = terms.times(partial, tangent.scale)
            weights[tangent.base] = weights.get(tangent.base, S.Zero) + weight
            bases[tangent.base] = tangent
    weights = {base: weight for base, weight in weights.items() if weight is not S.Zero}
    if not weights:
        return None
    if len(weights) == 1:
        ((base, weight),) = weights.items()
        return _Tangent(base, weight, bases[base].entries)
    summands: dict[Hashable, list[Term]] = {}
    for base, weight in weights.items():
        for seed, entry in bases[base].entries.items():
            summands.setdefault(seed, []).append(terms.times(weight, entry))
    return _joined(node, {seed: Add(*found) for seed, found in summands.items()})


def _branch(
    terms: Terms, node: int, branch: tuple[int, int, int], found: Mapping[int, _Tangent]
) -> _Tangent | None:
    """Tangents of the arm that is taken."""
    condition, taken, otherwise = terms.leaf(branch[0]), found.get(branch[1]), found.get(branch[2])

    def chosen(a: Term, b: Term) -> Term:
        return a if a == b else select(condition, terms.atom(a), terms.atom(b))

    if taken is not None and otherwise is not None and taken.base == otherwise.base:
        return _Tangent(taken.base, chosen(taken.scale, otherwise.scale), taken.entries)
    first, second = _entries(terms, taken), _entries(terms, otherwise)
    seeds = {**first, **second}
    return _joined(node, {s: chosen(first.get(s, S.Zero), second.get(s, S.Zero)) for s in seeds})


def _entries(terms: Terms, tangent: _Tangent | None) -> Entries:
    """Multiply the tangents out."""
    if tangent is None:
        return {}
    products = {s: terms.times(tangent.scale, e) for s, e in tangent.entries.items()}
    return {seed: entry for seed, entry in products.items() if entry is not S.Zero}


def _joined(node: int, entries: Mapping[Hashable, Term]) -> _Tangent | None:
    left = {seed: entry for seed, entry in entries.items() if entry is not S.Zero}
    return _Tangent(node, S.One, left) if left else None
