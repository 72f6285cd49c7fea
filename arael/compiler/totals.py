"""Sums over the rows of a collection, whose number is known with the data only.

A kernel has a fixed number of inputs, so a sum over any number of rows is computed before a solve.
Its term is written as a sum of products of a factor that depends on the row and one that does not,

    sum_i (a_i x - b_i)^2 = x^2 sum_i a_i^2 - 2 x sum_i a_i b_i + sum_i b_i^2,

and the kernel reads the sums of the factors that depend on rows. The other factors may depend on
parameters and are differentiated as usual. A term that is no such sum, or that reads parameters of
rows, is evaluated for each row (`row_sums.py`).
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.check import typed
from arael.check.typed import ConstraintSite
from arael.compiler.row_sums import RowSum, SumInput, require_flat
from arael.compiler.scalarise import Nodes, RawInput, StateInput
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Raw, Slot, Step, Total, Use, without_row_slots
from arael.symbolic.graph import Graph

MAX_PRODUCTS = 100
"""Products that the term of a sum is expanded into."""

Terms = dict[int, int]
"""Factor that depends on the row -> factor that does not."""


class Totals:
    """Expands the sums of one constraint.

    Parameters
    ----------
    slots_of_uses : the slots of the entities that the constraint reads
    mark : makes names differ from those of other `Totals` of the constraint; where it is given,
        sums are over data alone

    Attributes
    ----------
    found : sums that the runtime computes before a solve
    rows : sums that are evaluated term by term
    """

    def __init__(
        self, graph: Graph, site: ConstraintSite, uses: Sequence[Use], mark: str = ""
    ) -> None:
        self.graph = graph
        self.site = site
        self.uses = uses
        self.mark = mark
        self.found: list[Total] = []
        self.rows: list[RowSum] = []

    def of(self, total: typed.Total, terms: Nodes) -> Nodes:
        """Scalars of a sum, from those of its term.

        Raises
        ------
        AraelError
            E0621: a sum over data alone, or one with a sum over rows within it, whose term is no
            sum of products of a factor of the row and another.
        """
        g, site = self.graph, self.site
        try:
            if self._reads_parameters(total, terms):
                return self._term_by_term(total, terms)
            parted = [_Parts(g, site, total).of(node) for node in terms]
        except _Inseparable as found:
            if self.mark:
                raise found.error from None
            return self._term_by_term(total, terms)
        owner = site.slots[total.slot].table
        field = total.collection.removeprefix(f"{owner}." if owner else "")
        # Unique among the sums over this collection in all constraints.
        name = f"{field}#{site.table}:{site.prefix}{site.name}{self.mark}:{len(self.found)}"
        factors = list(dict.fromkeys(factor for part in parted for factor in part))
        result = []
        for part in parted:
            node = g.const(0.0)
            for factor, other in part.items():
                summed = g.input(RawInput(total.slot, name, factors.index(factor)))
                node = g.op("add", node, g.op("mul", other, summed))
            result.append(node)
        self.found.append(self._program(total, name, owner, factors))
        return result

    def _reads_parameters(self, total: typed.Total, terms: Nodes) -> bool:
        """Whether a term reads what moves in a solve from the row or through it."""
        g, rows = self.graph, self.site.slots[total.rows].steps
        for node in g.live(terms):
            key = g.key(node) if g.ops[node] == "input" else None
            if isinstance(key, StateInput):
                slot = self.uses[key.use].slot
            elif isinstance(key, SumInput):
                slot = key.owner
            else:
                continue
            if self.site.slots[slot].steps[: len(rows)] == rows:
                return True
        return False

    def _term_by_term(self, total: typed.Total, terms: Nodes) -> Nodes:
        """Scalars of a sum whose terms are evaluated for each row."""
        require_flat(self.site, self.graph, total, terms)
        number = len(self.rows)
        self.rows.append(RowSum(total, terms))
        return [self.graph.input(SumInput(number, k, total.slot)) for k in range(len(terms))]

    def _program(self, total: typed.Total, name: str, owner: str, factors: list[int]) -> Total:
        """The factors that depend on rows as a program over the data of a row."""
        g, site = self.graph, self.site
        slots = [Slot((), total.collection)]
        program = Graph()
        copies: dict[int, int] = {}
        raws: list[tuple[RawInput, Raw]] = []
        for node in g.live(factors):
            if g.ops[node] != "input":
                continue
            key = g.key(node)
            assert isinstance(key, RawInput)
            steps = _from_row(site, total, key.slot)
            assert steps is not None
            way = Slot(steps, site.slots[key.slot].table)
            if way not in slots:
                slots.append(way)
            copies[node] = program.input(key)
            raws.append((key, Raw(slots.index(way), key.column, key.component)))
        outputs = g.copy(factors, program, copies)
        tape = program.tape(outputs, inputs=[key for key, _ in raws])
        terms = tuple(raw for _, raw in raws)
        return Total(name, owner, total.collection, tuple(slots), terms, tape)


class _Inseparable(Exception):
    """A term is no sum of products; `error` is for a sum that must be one."""

    def __init__(self, error: AraelError) -> None:
        super().__init__()
        self.error = error


class _Parts:
    """Writes nodes as sums of products for one sum."""

    def __init__(self, graph: Graph, site: ConstraintSite, total: typed.Total) -> None:
        self.graph = graph
        self.total = total
        self.one = graph.const(1.0)
        rows = site.slots[total.rows].steps
        of_row: set[int] = set()
        other: set[int] = set()
        for key in list(graph.inputs):
            node = graph.input(key)
            if not isinstance(key, RawInput):
                other.add(node)
                continue
            if site.slots[key.slot].steps[: len(rows)] == rows:
                of_row.add(node)
            if _from_row(site, total, key.slot) is None:
                other.add(node)
        self.of_row = graph.depends(of_row)
        self.other = graph.depends(other)

    def of(self, node: int) -> Terms:
        """The products that `node` is the sum of."""
        done: dict[int, Terms] = {}
        for one in self.graph.live([node]):
            if one not in self.of_row:
                done[one] = {self.one: one}
            elif one not in self.other:
                done[one] = {one: self.one}
            else:
                parts = self._expand(one, [done[o] for o in self.graph.operands(one)])
                if parts is None or len(parts) > MAX_PRODUCTS:
                    raise _Inseparable(self._refusal(one, parts))
                done[one] = parts
        return done[node]

    def _expand(self, node: int, operands: list[Terms]) -> Terms | None:
        g, name = self.graph, self.graph.ops[node]
        if name == "add":
            return self._sum(*operands)
        if name == "sub":
            return self._sum(operands[0], self._negated(operands[1]))
        if name == "neg":
            return self._negated(operands[0])
        if name == "mul":
            return self._product(*operands)
        if name == "div" and len(operands[1]) == 1:
            ((factor, other),) = operands[1].items()
            return self._product(
                operands[0], {g.op("div", self.one, factor): g.op("div", self.one, other)}
            )
        if name == "select" and len(operands[0]) == 1:
            (condition,) = operands[0].items()
            return self._sum(
                self._where(condition, operands[1], True),
                self._where(condition, operands[2], False),
            )
        return None

    def _where(self, condition: tuple[int, int], parts: Terms, holds: bool) -> Terms:
        """The parts where a condition holds, or where it does not; zero elsewhere.

        Zeros are selected, not multiplied, because what is not taken need not be finite.
        """
        g, zero = self.graph, self.graph.const(0.0)
        of_row, other = condition

        def chosen(test: int, value: int) -> int:
            arms = (value, zero) if holds else (zero, value)
            return g.op("select", test, *arms)

        if other == self.one:
            return {chosen(of_row, factor): rest for factor, rest in parts.items()}
        return {factor: chosen(other, rest) for factor, rest in parts.items()}

    def _sum(self, *all_parts: Terms) -> Terms:
        terms: Terms = {}
        for parts in all_parts:
            for factor, other in parts.items():
                before = terms.get(factor)
                terms[factor] = other if before is None else self.graph.op("add", before, other)
        return terms

    def _negated(self, parts: Terms) -> Terms:
        return {factor: self.graph.op("neg", other) for factor, other in parts.items()}

    def _product(self, left: Terms, right: Terms) -> Terms:
        g = self.graph
        if len(left) * len(right) > 4 * MAX_PRODUCTS:
            return dict.fromkeys(range(MAX_PRODUCTS + 1), self.one)
        return self._sum(
            *(
                {g.op("mul", a, b): g.op("mul", x, y)}
                for a, x in left.items()
                for b, y in right.items()
            )
        )

    def _refusal(self, node: int, parts: Terms | None) -> AraelError:
        name = self.graph.ops[node]
        what = f"`{name}` joins data of a row with what is no data"
        if parts is not None:
            what = f"expands into more than {MAX_PRODUCTS} products"
        return AraelError(
            Diagnostic(
                "E0621",
                "the term of this sum is no sum of products of row data and parameters",
                self.total.span,
                what,
                notes=(
                    "the number of rows is known with the data only, so that sums of their data "
                    "are formed before a solve",
                ),
                help=(
                    "let what is no data of a row stand outside of the sum, or sum over a list of "
                    "refs of fixed length",
                ),
            )
        )


def _from_row(site: ConstraintSite, total: typed.Total, slot: int) -> tuple[Step, ...] | None:
    """The way from a row of the collection to that of a slot; None if there is none.

    It leads on from the row, up to the owner and on from there, or to the root.
    """
    steps = site.slots[slot].steps
    rows, owner = site.slots[total.rows].steps, site.slots[total.slot].steps
    if steps[: len(rows)] == rows:
        return steps[len(rows) :]
    if steps[:1] == (Step("root"),):
        return steps
    if steps[: len(owner)] == owner:
        return (Step("parent"), *steps[len(owner) :])
    return None


def slots_of_rows(site: ConstraintSite) -> tuple[Slot, ...]:
    """The slots of a constraint, with its own row in place of what a sum runs over.

    The rows of a sum are read by its own program; the numbers of the other slots stay the same.
    """
    return without_row_slots(site.slots)
