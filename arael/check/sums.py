"""Rule: a sum runs over a list, and its body is a number, a vector or a matrix.

Allowed: ``sum(k in self.knots) { ... }`` over a list of refs; over refs written in brackets,
``sum(p in [a, b, c]) { ... }``; over the elements of a vector; with the number of the element,
``sum(i, k in knots) { B[i] * k.pos }``; `let`s in its body; a sum within a sum. Over the rows of a
collection, ``sum(x in self.items) { x.a * p }``, with their data and parameters.

Not allowed: a single entity; a name that is in use already; a truth value or a rotation as body;
numbers of the rows of a collection.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from arael.check.binding import BROKEN, Binding, Broken, Collection, Entity, RefList, describe
from arael.check.builtins import widened
from arael.check.field_reads import row_is_there
from arael.check.operators import result_type
from arael.check.scope import Candidate, Scope
from arael.check.typed import INT, REAL, Component, Literal_, Total, Typed, VectorType
from arael.check.typist import Typist
from arael.diagnostics.records import Label, Span
from arael.runtime.layout import Step
from arael.syntax import tree


@dataclass
class SumScope:
    """Inside a sum: its names and its `let`s, then the scope around it."""

    around: Scope
    own: dict[str, tuple[Binding, Span]]

    def candidates(self, name: str) -> list[Candidate]:
        """All candidates for `name`."""
        if name not in self.own:
            return self.around.candidates(name)
        binding, span = self.own[name]
        entity = binding if isinstance(binding, Entity) else None
        return [Candidate("a name of a sum", span, lambda _: binding, entity)]

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""
        return [*self.own, *self.around.names()]

    def advice(self, name: str) -> list[str]:
        """Help for the unknown name `name`."""
        return self.around.advice(name)


def sum_over(t: Typist, node: tree.Sum) -> Binding:
    """``sum(i, k in list) { body }``: the body for each element, added."""
    idents = [ident for ident in (node.index, node.element) if ident is not None]
    over = _list(t, node.over)
    elements = [over] if isinstance(over, Collection) else over
    if elements is None or not _are_free(t, idents, node.body):
        return BROKEN
    if isinstance(over, Collection):
        return _over_rows(t, node, over)
    total: Typed | None = None
    for number, element in enumerate(elements):
        names: dict[str, tuple[Binding, Span]] = {node.element.id: (element, node.element.span)}
        if node.index is not None:
            literal = Literal_(type=INT, span=node.index.span, value=float(number))
            names[node.index.id] = (t.make(literal), node.index.span)
        term = _term(t, node, names)
        if isinstance(term, Broken):
            return BROKEN
        if total is None:
            total = term
            continue
        joined = t.apply(node, "add", [total, term], widened(total.type))
        if not isinstance(joined, Typed):
            return BROKEN
        total = joined
    assert total is not None
    return total


def _over_rows(t: Typist, node: tree.Sum, over: Collection) -> Binding:
    """A sum over the rows of a collection, which need not be few or as many everywhere."""
    owner = over.owner
    if node.index is not None:
        return t.fail(
            "E0612",
            node.index.span,
            "the rows of a collection have no number in a sum",
            label="only a list of fixed length has",
            help=[f"write `sum({node.element.id} in {node.over.span.text}) {{ ... }}`"],
        )
    if isinstance(row_is_there(t, owner, node.over.span), Broken):
        return BROKEN
    steps = (*owner.steps, Step("rows", over.site.path))
    row = Entity(steps, over.site.place, owner, owner.needs)
    slot, rows = t.slots.of(owner), t.slots.of(row)
    term = _term(t, node, {node.element.id: (row, node.element.span)})
    if isinstance(term, Broken):
        return BROKEN
    total = Total(
        type=widened(term.type),
        span=node.span,
        of=term,
        slot=slot,
        rows=rows,
        collection=over.site.path,
    )
    return t.make(total)


def _list(t: Typist, node: tree.Expr) -> Sequence[Binding] | Collection | None:
    """What a sum runs over, element by element, or a collection; None after an error."""
    if isinstance(node, tree.ListExpr) and node.items:
        items = [t.visit(item) for item in node.items]
        if any(isinstance(one, Broken) for one in items):
            return None
        if all(isinstance(one, Entity) for one in items):
            return items
        over: Binding = t.value(node)
    else:
        over = t.visit(node)
    if isinstance(over, Broken):
        return None
    if isinstance(over, Collection):
        return over
    if isinstance(over, RefList):
        items = [t.paths.follow(over.owner, element) for element in over.field.elements]
        return None if any(isinstance(one, Broken) for one in items) else items
    if isinstance(over, Typed) and isinstance(over.type, VectorType):
        parts = range(over.type.n)
        return [t.make(Component(type=REAL, span=node.span, of=over, index=k)) for k in parts]
    help_ = ["declare a list of refs, `knots: [ref Knot in root.knots; 4]`, and sum over `knots`"]
    if isinstance(over, Entity):
        help_ = ["write `[a, b, c]` for a sum over several"]
    t.fail("E0612", node.span, "a sum runs over a list", label=f"this is {describe(over)}",
           help=help_)  # fmt: skip
    return None


def _are_free(t: Typist, idents: Sequence[tree.Ident], body: tree.Body) -> bool:
    """Whether the names that a sum introduces have no other meaning here."""
    taken: dict[str, Span] = {}
    for ident in (*idents, *(let.name for let in body.lets)):
        candidates = t.scope.candidates(ident.id)
        labels = [Label(c.span, c.what) for c in candidates if c.span is not None]
        if ident.id in taken:
            labels = [Label(taken[ident.id], "first declared here")]
        elif not candidates:
            taken[ident.id] = ident.span
            continue
        t.fail(
            "E0207",
            ident.span,
            f"`{ident.id}` has another meaning here",
            label="declared again" if ident.id in taken else f"this is {candidates[0].what}",
            labels=labels,
            help=["use a new name in the sum"],
        )
        return False
    return True


def _term(t: Typist, node: tree.Sum, names: dict[str, tuple[Binding, Span]]) -> Typed | Broken:
    """The body of a sum for one element."""
    before = t.scope
    t.scope = SumScope(before, names)
    try:
        for let in node.body.lets:
            names[let.name.id] = (t.visit(let.value), let.name.span)
        term = t.number(node.body.result)
    finally:
        t.scope = before
    if isinstance(term, Typed) and result_type("+", term.type, term.type) is None:
        return t.fail(
            "E0301",
            node.body.result.span,
            f"`{term.type} + {term.type}` does not fit",
            label=f"this is {term.type}",
            help=["a sum adds numbers, vectors or matrices"],
        )
    return term
