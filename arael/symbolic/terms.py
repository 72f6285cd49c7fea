"""A graph as SymPy sees it: its nodes are symbols, derivatives are short terms over them.

SymPy never sees a formula in full, only definitions of a few operations whose operands are symbols.
So it may sort and combine the terms of a derivative as it does best, while values are evaluated as
the model wrote them, and expressions stay small.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sympy import Add, Rational, S, Symbol

from arael.symbolic.derivatives import CONSTANTS, FORMAL, FUNCTION_OF, MAKERS, VALUE, partials
from arael.symbolic.graph import Graph

Term = Any
"""A SymPy expression over symbols of nodes and definitions."""

# Only numbers that SymPy multiplies as exactly as floating point does become numbers; others are
# symbols.
_LARGEST_DENOMINATOR = 1024
_LARGEST_NUMERATOR = 1 << 20

# Terms in a sum, factors in a product: a longer one is a definition of its own, since the time that
# SymPy takes for an operation grows with both.
_LONGEST = 40


def exact(value: float, largest: float = _LARGEST_NUMERATOR) -> Term | None:
    """`value` as a SymPy number if it is a short binary fraction of at most `largest`."""
    if not abs(value) <= largest:
        return None
    numerator, denominator = value.as_integer_ratio()
    return Rational(numerator, denominator) if denominator <= _LARGEST_DENOMINATOR else None


class Terms:
    """Terms over the nodes of one graph, and the sums among them that are definitions.

    Parameters
    ----------
    graph : whose nodes become symbols
    nodes : those whose values derivatives may use, in order of evaluation

    Attributes
    ----------
    symbols : symbol -> node
    definitions : symbol -> (sum that it stands for, place), in order of creation
    place : place of what is derived now; new definitions remember it
    """

    def __init__(self, graph: Graph, nodes: Iterable[int]) -> None:
        self.graph = graph
        self.symbols: dict[Term, int] = {}
        self.definitions: dict[Term, tuple[Term, int | None]] = {}
        self.place: int | None = None
        self._place = graph.place
        self._leaves: dict[int, Term] = {}
        self._sums: dict[int, Term] = {}
        self._known: dict[Term, Term] = {}
        for node in nodes:
            self._learn(node)

    def fresh(self) -> Terms:
        """Terms over the same nodes without definitions, for another order of derivation."""
        other = Terms(self.graph, ())
        other.symbols, other._leaves = dict(self.symbols), dict(self._leaves)
        other._sums, other._known = self._sums, dict(self._known)
        return other

    def at(self, node: int) -> None:
        """Let what is made from now on remember the place of `node`."""
        self.place = self.graph.place_of(node)
        self.graph.place = self._place if self.place is None else self.place

    def leaf(self, node: int) -> Term:
        """Symbol of `node`, with sign and power of two in front if it has one; or a number."""
        found = self._leaves.get(node)
        if found is None:
            found = self._leaves[node] = self._leaf(node)
        return found

    def _leaf(self, node: int) -> Term:
        g = self.graph
        name, args = g.ops[node], g.args[node]
        value = g.value(node)
        if value is not None and (number := exact(value)) is not None:
            return number
        if name == "neg":
            return -self.leaf(args[0])
        if g.is_free(node):
            return self.leaf(args[0])
        if name == "mul" and g.value(args[0]) in (0.5, 2.0):
            return self.leaf(args[0]) * self.leaf(args[1])
        # The number is padded, since SymPy orders symbols by name.
        symbol = Symbol(f"v{node:07d}")
        self.symbols[symbol] = node
        return symbol

    def _learn(self, node: int) -> None:
        """Remember what a function computes, and a sum, whatever the order of its terms."""
        function = FUNCTION_OF.get(self.graph.ops[node])
        if function is not None:
            value = function(*map(self.leaf, self.graph.args[node]))
            self._known.setdefault(value, self.leaf(node))
        if self.graph.ops[node] not in ("add", "sub", "mul"):
            return
        total = self._sum(node)
        if total.is_Add:
            factor, terms = primitive(total)
            self._known.setdefault(terms, self.leaf(node) / factor)

    def _sum(self, node: int) -> Term:
        """Value of `node` as a sum of products."""
        found = self._sums.get(node)
        if found is None:
            name, args = self.graph.ops[node], self.graph.args[node]
            if name in ("add", "sub", "mul"):
                part = self._factor if name == "mul" else self._summand
                found = MAKERS[name](*map(part, args))
            else:
                found = self.leaf(node)
            self._sums[node] = found
        return found

    def _summand(self, node: int) -> Term:
        total = self._sum(node)
        return total if len(total.args) <= _LONGEST else self.leaf(node)

    def _factor(self, node: int) -> Term:
        total = self._sum(node)
        short = total.is_Symbol or (total.is_Mul and len(total.args) <= _LONGEST)
        return total if short else self.leaf(node)

    def atom(self, term: Term) -> Term:
        """`term` as a short product: a sum becomes a symbol that is defined as that sum."""
        if not term.is_Add and len(term.args) <= _LONGEST:
            return term
        factor, terms = primitive(term) if term.is_Add else (S.One, term)
        symbol = self._known.get(terms)
        if symbol is None:
            symbol = self._known[terms] = Symbol(f"w{len(self.definitions):07d}")
            self.definitions[symbol] = terms, self.place
        return factor * symbol

    def times(self, a: Term, b: Term) -> Term:
        """Product of two terms."""
        if a is S.Zero or b is S.Zero:
            return S.Zero
        if a is S.One or b is S.One:
            return b if a is S.One else a
        return self.atom(a) * self.atom(b)

    def partials(self, node: int) -> list[tuple[int, Term]]:
        """Pairs of an operand and the derivative of `node` by it; not of branches."""
        g = self.graph
        name, args = g.ops[node], g.args[node]
        if name == "custom":
            return [(a, self.leaf(p)) for a, p in zip(args[1::2], args[2::2], strict=True)]
        if name in g.functions:
            function = g.functions[name]
            args = function.arguments(args)
            if function.partials is not None:
                made = function.partials(g, args)
                return [(a, self.leaf(p)) for a, p in zip(args, made, strict=True)]
            name = function.name
        known: dict[Term, Term] = dict(zip(FORMAL, map(self.leaf, args), strict=False))
        known[VALUE] = self.leaf(node)
        return [(args[k], self._filled(p, known)) for k, p in partials(name, len(args))]

    def _filled(self, term: Term, known: dict[Term, Term]) -> Term:
        """`term` with terms of this graph for its symbols; sums within it become definitions."""
        found = known.get(term)
        if found is None:
            found = term
            if term in CONSTANTS:
                found = self.leaf(self.graph.const(CONSTANTS[term]))
            elif term.args:
                found = term.func(*(self.atom(self._filled(a, known)) for a in term.args))
                found = self._known.get(found, found)
            known[term] = found
        return found


def primitive(total: Term) -> tuple[Term, Term]:
    """Split a sum into a factor and a sum whose first sign is plus; their product is `total`."""
    sizes = {abs(term.as_coeff_Mul()[0]) for term in total.args}
    factor = sizes.pop() if len(sizes) == 1 else S.One
    if total.could_extract_minus_sign():
        factor = -factor
    return factor, total if factor == 1 else Add(*(term / factor for term in total.args))
