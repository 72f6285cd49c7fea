"""Constraints as SymPy has them: values, shared subexpressions, derivatives (`--stage sympy`)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

import click
import sympy as sp

from arael.check.typed import ConstraintSite, TypedModel
from arael.compiler.entities import model_state
from arael.compiler.groups import Derivatives, derivatives
from arael.compiler.scalar_programs import Functions
from arael.runtime.machine.tape import NATIVE
from arael.symbolic.derivatives import MAKERS


def formulas(
    model: TypedModel, precision: str | None, constraint: str | None, latex: bool = False
) -> str:
    """Print the constraints of `model`, or the one called `constraint`.

    Raises
    ------
    click.BadParameter
        The model has no such constraint.
    """
    functions = Functions(model.functions)
    states = [model_state(site, functions) for site in model.entities]
    single = (precision or model.precision) == "f32"
    sites = [s for s in model.constraints if constraint in (None, s.label)]
    if not sites:
        known = sorted({site.label for site in model.constraints})
        near = get_close_matches(str(constraint), known, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(known)}"
        raise click.BadParameter(
            f"the model has no constraint {constraint!r}; {hint}", param_hint="--constraint"
        )
    parts = (
        _constraint(site, derivatives(site, states, single, functions), latex) for site in sites
    )
    return "\n\n".join("\n".join(lines) for lines in parts)


def _constraint(site: ConstraintSite, found: list[Derivatives], latex: bool) -> Iterator[str]:
    yield f"constraint {site.label}  ({site.span})"
    if not found:
        yield "  reads no parameter: no derivatives"
        return
    graph, written, count = found[-1].shared.terms.graph, [], 0
    for section in found:
        rows = section.shared.write()
        count += sum(map(len, rows))
        written += [*section.values, *(node for row in rows for node in row.values())]
    yield (
        f"  {len(found[-1].values)} residuals, {count} derivatives, "
        f"{graph.tree_operations(written)} operations before and {graph.operations(written)} after "
        "common subexpressions"
    )
    if site.guard is not None:
        yield f"  when {' '.join(site.guard.span.text.split())}"
    for section in found:
        yield from _Printer(section, latex).lines()


class _Printer:
    """Prints terms with the names of the model in place of numbers of nodes.

    ``t`` are values, ``x`` shared subexpressions, ``w`` sums that derivatives use as factors.
    """

    def __init__(self, found: Derivatives, latex: bool) -> None:
        self.found, self.latex = found, latex
        self.terms = found.shared.terms

    def lines(self) -> Iterator[str]:
        """Sections of a constraint, each line after those that it reads."""
        graph, shared = self.terms.graph, self.found.shared
        definitions = {symbol: term for symbol, (term, _) in shared.definitions.items()}
        derived = [term for row in shared.rows for term in row.values()]
        common = self._in_order({**shared.subexpressions, **definitions}, derived)
        read = {s for term in (*common.values(), *derived) for s in term.free_symbols}
        nodes = [self.terms.symbols[s] for s in read if s in self.terms.symbols]
        letter = "v" if self.found.title else "r"
        one = "guard" if self.found.title == "guard" else ""
        yield f"  {self.found.title}" if self.found.title else "  values"
        for node in graph.live([*self.found.values, *nodes]):
            name = graph.ops[node]
            if name not in ("input", "const", "neg") and not graph.is_free(node):
                make = MAKERS.get(name, sp.Function(name.removeprefix(NATIVE)))
                with sp.evaluate(False):
                    value = make(*(self._named(self.terms.leaf(a)) for a in graph.args[node]))
                yield self._line(f"t{node}", value)
        for k, node in enumerate(self.found.values):
            yield self._line(one or f"{letter}{k}", self._named(self.terms.leaf(node)))
        if common:
            yield "  shared subexpressions"
        for symbol, term in common.items():
            yield self._line(_short(symbol), self._named(term))
        if derived:
            yield "  derivatives"
        for k, row in enumerate(shared.rows):
            for seed, term in row.items():
                by = self.found.tangents[seed]
                yield self._line(f"d {letter}{k} / d {by}", self._named(term))

    @staticmethod
    def _in_order(known: dict[Any, Any], wanted: list[Any]) -> dict[Any, Any]:
        """The symbols that `wanted` need, with their terms, in order of evaluation."""
        found: dict[Any, Any] = {}

        def missing(term: Any) -> list[Any]:
            symbols = (s for s in term.free_symbols if s in known and s not in found)
            return sorted(symbols, key=lambda s: str(s.name), reverse=True)

        # With a stack of its own: subexpressions may be thousands deep.
        waiting = [symbol for term in reversed(wanted) for symbol in missing(term)]
        while waiting:
            more = missing(known[waiting[-1]])
            if not more:
                symbol = waiting.pop()
                found[symbol] = known[symbol]
            waiting += more
        return found

    def _named(self, term: Any) -> Any:
        return term.xreplace({symbol: self._name(symbol) for symbol in term.free_symbols})

    def _name(self, symbol: Any) -> Any:
        node = self.terms.symbols.get(symbol)
        if node is None:
            return sp.Symbol(_short(symbol))
        value = self.terms.graph.value(node)
        if value is not None:
            return sp.Symbol(repr(value))
        return sp.Symbol(self.found.names.get(node, f"t{node}"))

    def _line(self, name: str, term: Any) -> str:
        if not self.latex:
            return f"    {name} = {sp.sstr(term, order='none')}"
        names = {symbol: _tex(symbol.name) for symbol in term.free_symbols}
        return f"    {_tex(name)} = {sp.latex(term, order='none', symbol_names=names)}"


def _tex(name: str) -> str:
    """Name in LaTeX's mathematics: ``t12`` with an index, ``info.cov_r[2]`` upright."""
    if name.startswith("d "):
        above, below = name.removeprefix("d ").split(" / d ")
        return rf"\frac{{\partial {_tex(above)}}}{{\partial {_tex(below)}}}"
    if re.fullmatch(r"[rtvwx]\d+", name):
        return f"{name[0]}_{{{name[1:]}}}"
    if re.fullmatch(r"[-\d.e+]+", name):
        return name
    stem, _, index = name.partition("[")
    text = rf"\mathrm{{{stem}}}".replace("_", r"\_")
    return f"{text}_{{{index.rstrip(']')}}}" if index else text


def _short(symbol: Any) -> str:
    """Name of a symbol without the zeros that keep symbols in order."""
    return f"{symbol.name[0]}{int(symbol.name[1:])}"
