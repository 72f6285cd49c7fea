"""From terms back to a graph: common subexpressions by SymPy, written as operations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Generic

import sympy as sp
from sympy import S, Symbol

from arael.runtime.machine.tape import PRIMITIVES
from arael.symbolic.derivatives import MAKERS, OPERATION_OF
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from arael.symbolic.terms import Term, Terms
from arael.symbolic.varying import Seed

Rows = list[dict[Seed, Term]]


class Shared(Generic[Seed]):
    """Derivatives of some outputs with their common subexpressions.

    Attributes
    ----------
    definitions : symbol -> (term, place) of what the derivatives need, in order of evaluation
    subexpressions : symbol -> term of what definitions and derivatives have in common
    rows : per output, its derivative by each seed
    """

    def __init__(self, terms: Terms, outputs: Sequence[int], rows: Rows[Seed]) -> None:
        self.terms = terms
        self.outputs = outputs
        wanted = [term for row in rows for term in row.values()]
        needed = _needed(terms, wanted)
        defined = [term for term, _ in needed.values()]
        values = _values(terms, [*defined, *wanted])
        fresh = (Symbol(f"x{i:07d}") for i in range(1 << 62))
        found, reduced = sp.cse([*values, *defined, *wanted], symbols=fresh, order="none")
        self.subexpressions: dict[Term, Term] = dict(found)
        left = iter(reduced[len(values) :])
        self.definitions = {s: (next(left), place) for s, (_, place) in needed.items()}
        self.rows = [{seed: next(left) for seed in row} for row in rows]

    def write(self) -> list[dict[Seed, int]]:
        """Write the derivatives as nodes of the graph."""
        g = self.terms.graph
        writer = Writer(g, self.subexpressions, self.terms.symbols)
        saved = g.place
        for symbol, (term, place) in self.definitions.items():
            g.place = saved if place is None else place
            writer.nodes[symbol] = writer.write(term)
        result = []
        for output, row in zip(self.outputs, self.rows, strict=True):
            g.place = g.place_of(output, saved)
            result.append({seed: writer.write(term) for seed, term in row.items()})
        g.place = saved
        return result


def _needed(terms: Terms, wanted: Sequence[Term]) -> dict[Term, tuple[Term, int | None]]:
    """Definitions that `wanted` need, in order of creation, which is an order of evaluation."""
    needed = {symbol for term in wanted for symbol in term.free_symbols}
    for symbol, (term, _) in reversed(terms.definitions.items()):
        if symbol in needed:
            needed |= term.free_symbols
    return {s: d for s, d in terms.definitions.items() if s in needed}


def _values(terms: Terms, used: Sequence[Term]) -> list[Term]:
    """Sums and products that are computed anyway, so that derivatives share them."""
    g = terms.graph
    symbols = {symbol for term in used for symbol in term.free_symbols}
    live = g.live([terms.symbols[s] for s in symbols if s in terms.symbols])
    nodes = (node for node in live if g.ops[node] in ("add", "sub", "mul"))
    return [MAKERS[g.ops[node]](*map(terms.leaf, g.args[node])) for node in nodes]


def real(number: Any) -> float:
    """Value of a SymPy number; NaN where it is complex or infinite without a sign (1/0)."""
    try:
        return float(number)
    except TypeError:
        return math.nan


class Writer:
    """Writes terms as operations of a graph; a term that has been written is not again.

    Parameters
    ----------
    graph : where the operations go
    subexpressions : symbol -> term of what is written where it is needed first
    nodes : nodes of the other symbols
    """

    def __init__(
        self, graph: Graph, subexpressions: dict[Term, Term], nodes: Mapping[Term, int]
    ) -> None:
        self.graph = graph
        self.subexpressions = subexpressions
        self.nodes: dict[Term, int] = dict(nodes)

    def write(self, term: Term) -> int:
        """Node of `term`, after those of the subexpressions that it needs."""
        # With a stack of its own: subexpressions may be thousands deep.
        waiting = self._missing(term)
        while waiting:
            symbol = waiting[-1]
            missing = self._missing(self.subexpressions[symbol])
            if not missing:
                self.nodes[symbol] = self.node(self.subexpressions[symbol])
                waiting.pop()
            waiting += missing
        return self.node(term)

    def _missing(self, term: Term) -> list[Term]:
        """Subexpressions that `term` reads and that are not written yet, in order of name."""
        symbols = (s for s in term.free_symbols if s in self.subexpressions)
        return sorted((s for s in symbols if s not in self.nodes), key=lambda s: s.name)

    def node(self, term: Term) -> int:
        """Node of `term`, whose symbols all have nodes."""
        found = self.nodes.get(term)
        if found is None:
            found = self.nodes[term] = self._write(term)
        return found

    def _write(self, term: Term) -> int:
        g = self.graph
        if term.is_number:
            return g.const(real(term))
        if term.is_Add:
            return self._sum(term.args)
        if term.is_Mul:
            return self._product(term)
        if term.is_Pow:
            return self._power(term.base, term.exp)
        return self._operation(OPERATION_OF[term.func], [*map(self.node, term.args)])

    def _operation(self, name: str, args: Sequence[int]) -> int:
        g = self.graph
        return g.op(name, *args) if name in PRIMITIVES else SCALARS[name].build(g, *args)

    def _sum(self, terms: Sequence[Any]) -> int:
        """Write what is added first, then what is subtracted."""
        g = self.graph
        minus = [t for t in terms if t.could_extract_minus_sign()]
        plus = [t for t in terms if t not in minus]
        if not plus:
            return g.op("neg", self._sum([-t for t in minus]))
        total = self.node(plus[0])
        for t in plus[1:]:
            total = g.op("add", total, self.node(t))
        for t in minus:
            total = g.op("sub", total, self.node(-t))
        return total

    def _product(self, term: Term) -> int:
        """Write a product over a product; a reciprocal that is needed elsewhere is a factor."""
        g = self.graph
        if term.args[0] is S.NegativeOne:
            return g.op("neg", self.node(-term))
        above: list[Term] = []
        below: list[Term] = []
        for factor in term.args:
            negative = factor.is_Pow and factor.exp.is_number and factor.exp.is_negative
            (below if negative and factor not in self.nodes else above).append(factor)
        total = self._factors(above)
        return self._quotient(total, [1 / f for f in below]) if below else total

    def _quotient(self, above: int, below: Sequence[Any]) -> int:
        """Divide at the place of the innermost divisor: a division by zero is reported there."""
        g = self.graph
        saved = g.place
        divisors = [n for n in map(self.node, below) if g.value(n) is None]
        if divisors:
            g.place = g.place_of(min(divisors), saved)
        node = g.op("div", above, self._factors(below))
        g.place = saved
        return node

    def _factors(self, factors: Sequence[Any]) -> int:
        g = self.graph
        number = S.One
        product: int | None = None
        for factor in factors:
            if factor.is_number:
                number *= factor
                continue
            node = self.node(factor)
            product = node if product is None else g.op("mul", product, node)
        if product is None:
            return g.const(real(number))
        return product if number is S.One else g.op("mul", g.const(real(number)), product)

    def _power(self, base: Term, exponent: Term) -> int:
        g = self.graph
        if exponent.is_negative:
            return self._quotient(g.const(1.0), [base ** (-exponent)])
        if exponent == 1:
            return self.node(base)
        if exponent.is_Integer:  # by squaring
            half = self.node(base ** (exponent // 2))
            square = g.op("mul", half, half)
            return square if exponent % 2 == 0 else g.op("mul", square, self.node(base))
        if (2 * exponent).is_Integer:
            root = g.op("sqrt", self.node(base))
            whole = exponent - S.Half
            return root if whole == 0 else g.op("mul", self.node(base**whole), root)
        return g.op("pow", self.node(base), self.node(exponent))
