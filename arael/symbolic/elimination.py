"""Derivatives by vertex elimination: between forward and reverse mode, whichever is shorter.

The program is seen as a graph whose edges carry partial derivatives, from each node to its
operands. Eliminating an inner node joins every edge into it with every edge out of it: weights
along a path are multiplied, parallel paths added. When no inner node is left, the edges are the
Jacobian. Forward mode eliminates in order of evaluation, reverse mode in the opposite order; a
greedy choice of the node that costs least (Markowitz) is often cheaper than both. Griewank and
Walther, Evaluating Derivatives, 2nd ed., chapter 9.

What branches depend on is differentiated in forward mode, so that the derivative of an arm that is
not taken is discarded by a select and never multiplied by zero, since it may be NaN.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Mapping

from sympy import S

from arael.symbolic.forward import forward
from arael.symbolic.terms import Term, Terms
from arael.symbolic.varying import Seed, arguments, branches, rank_of_seeds, varying


def eliminate(
    terms: Terms, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> list[dict[Seed, Term]]:
    """Differentiate as `arael.symbolic.forward.forward` does, the cheapest node first."""
    outputs = list(outputs)
    graph = terms.graph
    rank = rank_of_seeds(seeds)
    names = list(rank)
    order = varying(graph, outputs, seeds)
    ready = _below_branches(terms, order, seeds)
    linear = _Linearised(terms, top=max(order, default=0) + 1)
    for node in order:
        terms.at(node)
        if node in ready or node in seeds:
            tangents = seeds.get(node, {})
            found = ready.get(node) or {seed: terms.leaf(t) for seed, t in tangents.items()}
            for seed, entry in found.items():
                linear.add_edge(node, -1 - rank[seed], entry)
        elif any(operand in linear.below for operand in arguments(graph, node)):
            for operand, partial in terms.partials(node):
                linear.add_edge(node, operand, partial)
    for k, node in enumerate(outputs):
        linear.add_edge(linear.top + k, node, S.One)
    linear.run()
    result: list[dict[Seed, Term]] = []
    for k, node in enumerate(outputs):
        terms.at(node)
        row = linear.below.get(linear.top + k, {})
        result.append({names[-1 - v]: terms.atom(row[v]) for v in sorted(row, reverse=True)})
    return result


def _below_branches(
    terms: Terms, order: list[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> dict[int, dict[Seed, Term]]:
    """Derivatives of branches and of what they depend on."""
    graph = terms.graph
    taken = [n for n in order if n not in seeds and branches(graph, n) is not None]
    found = set(varying(graph, taken, seeds))
    nodes = [node for node in order if node in found and node not in seeds]
    return dict(zip(nodes, forward(terms, nodes, seeds), strict=True))


class _Linearised:
    """The edges of the linearised program that are left.

    A vertex is the number of a node; or `top` and more, an output; or negative, a seed.
    """

    def __init__(self, terms: Terms, top: int) -> None:
        self.terms = terms
        self.top = top
        self.below: dict[int, dict[int, Term]] = {}
        self.above: dict[int, dict[int, None]] = {}

    def add_edge(self, upper: int, lower: int, weight: Term) -> None:
        """Add `weight` to an edge; zero weights are no edges."""
        if weight is S.Zero or (lower >= 0 and lower not in self.below):
            return
        edges = self.below.setdefault(upper, {})
        edges[lower] = edges.get(lower, S.Zero) + weight
        if edges[lower] is S.Zero:
            del edges[lower]
            self.above.get(lower, {}).pop(upper, None)
        else:
            self.above.setdefault(lower, {})[upper] = None

    def run(self) -> None:
        """Eliminate every inner node, of those that cost the same the earliest first."""
        queue: list[tuple[int, int]] = []

        def enqueue(vertices: Iterable[int]) -> None:
            for vertex in vertices:
                if 0 <= vertex < self.top and vertex in self.below:
                    heapq.heappush(queue, (self._cost(vertex), vertex))

        enqueue(list(self.below))
        while queue:
            cost, vertex = heapq.heappop(queue)
            if vertex not in self.below:
                continue
            if cost != self._cost(vertex):
                enqueue([vertex])  # its surroundings have changed since
                continue
            lower, upper = self.below.pop(vertex), self.above.pop(vertex, {})
            for source in lower:
                self.above[source].pop(vertex, None)
            self.terms.at(vertex)
            for user in upper:
                outer = self.below[user].pop(vertex)
                for source, inner in lower.items():
                    self.add_edge(user, source, self.terms.times(outer, inner))
            enqueue([*lower, *upper])

    def _cost(self, vertex: int) -> int:
        """Count the products that eliminating a vertex takes; those with 1 and -1 are free."""
        lower = self.below[vertex]
        proper = sum(not _is_unit(weight) for weight in lower.values())
        above = self.above.get(vertex, {})
        return sum(0 if _is_unit(self.below[user][vertex]) else proper for user in above)


def _is_unit(weight: Term) -> bool:
    return weight is S.One or weight is S.NegativeOne
