"""Derivatives by vertex elimination: between forward and reverse mode, whichever is shorter.

The program is seen as a graph whose edges carry partial derivatives, from each node to its
operands. Eliminating an inner node joins every edge into it with every edge out of it: weights
along a path are multiplied, parallel paths added. When no inner node is left, the edges are the
Jacobian. Forward mode eliminates in order of evaluation, reverse mode in the opposite order; a
greedy choice of the node that costs least (Markowitz) is often cheaper than both. Griewank and
Walther, Evaluating Derivatives, 2nd ed., chapter 9.

Edges into an arm of a branch are guarded by its condition, and guards are kept along paths: what a
branch not taken yields is discarded with a select, never multiplied by zero, since it may be NaN.
"""

from __future__ import annotations

import heapq
from collections.abc import Hashable, Iterable, Mapping
from typing import NamedTuple, TypeVar

from arael.symbolic.graph import Graph
from arael.symbolic.partials import arguments, branches, partials
from arael.symbolic.varying import rank_of_seeds, varying

Seed = TypeVar("Seed", bound=Hashable)
Guards = tuple[tuple[int, bool], ...]
"""Conditions, as nodes, with the value that each must have; sorted."""
Weight = dict[Guards, int]
"""Partial derivative by the guards under which it counts; unguarded under the empty tuple."""


class _Vertex(NamedTuple):
    """A node of the program, a seed, or an output."""

    kind: int
    number: int


_SEED, _NODE, _OUTPUT = range(3)


def eliminate(
    graph: Graph, outputs: Iterable[int], seeds: Mapping[int, Mapping[Seed, int]]
) -> list[dict[Seed, int]]:
    """Differentiate as `arael.symbolic.derive.forward` does, the cheapest node first."""
    outputs = list(outputs)
    rank = rank_of_seeds(seeds)
    names = list(rank)
    linear = _Linearised(graph)
    for node in varying(graph, outputs, seeds):
        graph.place = graph.place_of(node, linear.place)
        linear.add_node(node, seeds.get(node), rank)
    one: Weight = {(): graph.const(1.0)}
    for k, node in enumerate(outputs):
        linear.add_edge(_Vertex(_OUTPUT, k), _Vertex(_NODE, node), one)
    linear.run()
    result: list[dict[Seed, int]] = []
    for k, node in enumerate(outputs):
        graph.place = graph.place_of(node, linear.place)
        row = {
            source.number: linear.plain(weight)
            for source, weight in linear.below.get(_Vertex(_OUTPUT, k), {}).items()
        }
        result.append(
            {names[s]: entry for s, entry in sorted(row.items()) if graph.value(entry) != 0}
        )
    graph.place = linear.place
    return result


class _Linearised:
    """The edges of the linearised program that are left."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.place = graph.place
        self.units = frozenset({graph.const(1.0), graph.const(-1.0)})
        self.zero = graph.const(0.0)
        self.below: dict[_Vertex, dict[_Vertex, Weight]] = {}
        self.above: dict[_Vertex, dict[_Vertex, None]] = {}

    def add_node(
        self, node: int, given: Mapping[Seed, int] | None, rank: Mapping[Seed, int]
    ) -> None:
        """Enter the edges from a node to what it varies through."""
        g, vertex = self.graph, _Vertex(_NODE, node)
        if given is not None:
            for seed, tangent in given.items():
                self.add_edge(vertex, _Vertex(_SEED, rank[seed]), {(): tangent})
        elif (branch := branches(g, node)) is not None:
            condition, taken, otherwise = branch
            one = g.const(1.0)
            for arm, holds in ((taken, True), (otherwise, False)):
                target = _Vertex(_NODE, arm)
                if target in self.below:
                    self.add_edge(vertex, target, {((condition, holds),): one})
        elif any(_Vertex(_NODE, operand) in self.below for operand in arguments(g, node)):
            for operand, partial in partials(g, node):
                target = _Vertex(_NODE, operand)
                if target in self.below:
                    self.add_edge(vertex, target, {(): partial})

    def add_edge(self, upper: _Vertex, lower: _Vertex, weight: Weight) -> None:
        """Add `weight` to an edge; zero weights are no edges."""
        weight = {guards: node for guards, node in weight.items() if node != self.zero}
        if not weight or (lower.kind == _NODE and lower not in self.below):
            return
        edges = self.below.setdefault(upper, {})
        edges[lower] = self._sum(edges.get(lower, {}), weight)
        if edges[lower]:
            self.above.setdefault(lower, {})[upper] = None
        else:
            del edges[lower]
            self.above.get(lower, {}).pop(upper, None)

    def run(self) -> None:
        """Eliminate every inner node, of those that cost the same the earliest first."""
        queue: list[tuple[int, _Vertex]] = []

        def enqueue(vertices: Iterable[_Vertex]) -> None:
            for vertex in vertices:
                if vertex.kind == _NODE and vertex in self.below:
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
            self.graph.place = self.graph.place_of(vertex.number, self.place)
            for user in upper:
                outer = self.below[user].pop(vertex)
                for source, inner in lower.items():
                    self.add_edge(user, source, self._product(outer, inner))
            enqueue([*lower, *upper])

    def _cost(self, vertex: _Vertex) -> int:
        """Count the products that eliminating a vertex takes; those with 1 and -1 are free."""
        lower = self.below[vertex]
        proper = sum(not self._is_unit(weight) for weight in lower.values())
        cost = 0
        for user in self.above.get(vertex, {}):
            cost += 0 if self._is_unit(self.below[user][vertex]) else proper
        return cost

    def _is_unit(self, weight: Weight) -> bool:
        return self.units.issuperset(weight.values())

    def _product(self, outer: Weight, inner: Weight) -> Weight:
        result: Weight = {}
        for guards, first in outer.items():
            for others, second in inner.items():
                joined = (
                    tuple(sorted({*guards, *others})) if guards and others else guards or others
                )
                if joined and any((condition, not holds) in joined for condition, holds in joined):
                    continue  # two guards that exclude each other
                product = self.graph.op("mul", first, second)
                result = self._sum(result, {joined: product})
        return result

    def _sum(self, first: Weight, second: Weight) -> Weight:
        """Add weights; the two sides of one branch become one select."""
        result = dict(first)
        for guards, node in second.items():
            self._enter(result, guards, node)
        return result

    def _enter(self, weight: Weight, guards: Guards, node: int) -> None:
        g = self.graph
        known = weight.pop(guards, None)
        if known is not None:
            node = g.op("add", known, node)
        if node == self.zero:
            return
        for i, (condition, holds) in enumerate(guards):
            opposite = tuple(sorted((*guards[:i], (condition, not holds), *guards[i + 1 :])))
            other = weight.pop(opposite, None)
            if other is not None:
                arms = (node, other) if holds else (other, node)
                self._enter(weight, guards[:i] + guards[i + 1 :], g.op("select", condition, *arms))
                return
        weight[guards] = node

    def plain(self, weight: Weight) -> int:
        """Resolve the guards of a finished derivative into selects."""
        g = self.graph
        result = zero = self.zero
        for guards, node in weight.items():
            for condition, holds in guards:
                arms = (node, zero) if holds else (zero, node)
                node = g.op("select", condition, *arms)
            result = g.op("add", result, node)
        return result
