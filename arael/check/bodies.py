"""Constraints: the guard, the lets and the residual of each, typed at each place of its struct."""

from __future__ import annotations

from collections.abc import Sequence

from arael.check.binding import Binding, Broken, Collection, Entity, describe
from arael.check.constants import Constants
from arael.check.expressions import HANDLERS, condition
from arael.check.field_reads import bind_field, presence
from arael.check.guards import Fact, facts_of
from arael.check.limits import MAX_MODEL_EXPANDED, MAX_MODEL_OPERATIONS
from arael.check.losses import loss_of
from arael.check.paths import Paths
from arael.check.places import Place
from arael.check.priors import prior_residual
from arael.check.report import Reporter
from arael.check.requirements import Requirement, check_guard, requirement_of
from arael.check.residual_rows import check_parameters, check_rows, residual_of
from arael.check.scope import BodyScope
from arael.check.typed import BOOL, Apply, ConstraintSite, Typed
from arael.check.typist import Slots, Typist
from arael.check.units_messages import residual_units
from arael.diagnostics.records import Label, Span
from arael.runtime.layout import Slot
from arael.syntax import tree


class Bodies:
    """Types constraints and fits."""

    def __init__(self, paths: Paths, constants: Constants, report: Reporter) -> None:
        self.paths = paths
        self.constants = constants
        self.report = report
        self.operations = 0
        self.expansion = 0
        self.full = False

    def constraint(self, place: Place, node: tree.Constraint) -> ConstraintSite | None:
        """A constraint at one place of its struct; None after an error."""
        home = Entity((), place)
        struct = place.struct
        return self._site(
            home,
            home,
            f"{struct.name}.{node.name.id}",
            node.name.id,
            node,
            {},
            index_column=_index_column(place, node),
        )

    def prior(self, place: Place, node: tree.Prior, name: str) -> ConstraintSite | None:
        """A prior at one place of its struct, as a constraint; None after an error."""
        home = Entity((), place)
        return self._site(home, home, f"{place.struct.name}.{name}", name, node, {})

    def fit(self, root: Place, node: tree.Fit, name: str) -> ConstraintSite | None:
        """A `fit` of the root: a constraint on each element of a collection."""
        start = Entity((), root)
        target = self.paths.walk(start, node.collection, own=True, through=True)
        if isinstance(target, Broken):
            return None
        if not isinstance(target, Collection):
            self.report.error(
                "E0608",
                node.collection.span,
                f"`{node.collection}` is not a collection",
                label=f"this is {describe(target)}",
                help=["`fit` runs over the elements of a `list of`, `deque of` or `arena of`"],
            )
            return None
        home = Entity((), target.site.place)
        own = self.paths.root(home)
        lets: dict[str, tuple[Binding, Span]] = {node.element.id: (home, node.element.span)}
        return self._site(home, own, f"{root.struct.name}.{name}", name, node, lets)

    def _site(
        self,
        home: Entity,
        entity: Entity,
        label: str,
        name: str,
        node: tree.Constraint | tree.Fit | tree.Prior,
        lets: dict[str, tuple[Binding, Span]],
        index_column: str = "",
    ) -> ConstraintSite | None:
        if self.full:
            return None
        before = len(self.report.findings.errors)
        t = self._typist(home, entity, lets)
        sigma: Typed | None = None
        required: Requirement | None = None
        with t.knowing(self._facts(home)):
            guard = self._guard(t, home, node.guard)
            facts = facts_of(guard, t.slots.steps)[0] if guard is not None else frozenset()
            with t.knowing(facts):
                loss = loss_of(t, node.loss) if node.loss is not None else None
                if isinstance(node, tree.Prior):
                    found = prior_residual(t, node)
                    residual = None if found is None else [found[0]]
                    sigma = None if found is None else found[1]
                elif isinstance(node, tree.Require):
                    self._lets(t, node.body, lets)
                    required = requirement_of(t, node.body.result)
                    good = check_guard(t, node, guard) and required is not None
                    residual = [*required.rows] if good and required is not None else None
                else:
                    self._lets(t, node.body, lets)
                    residual = residual_of(t, node.body.result)
        self.operations += t.operations
        self.expansion += t.expansion
        if self.operations > MAX_MODEL_OPERATIONS or self.expansion > MAX_MODEL_EXPANDED:
            self.full = True
            t.fail(
                "E0606",
                node.span,
                "the constraints of this model are too large together",
                label=f"more than {MAX_MODEL_OPERATIONS} scalar operations up to here"
                if self.operations > MAX_MODEL_OPERATIONS
                else f"calls of functions add more than {MAX_MODEL_EXPANDED} operations up to here",
            )
        if residual is None or len(self.report.findings.errors) > before:
            return None
        read = [*residual, *([] if loss is None else [loss.value])]
        if not check_rows(t, guard, read):
            return None
        if required is None:
            if not isinstance(node, tree.Prior) and not check_parameters(t, node, residual):
                return None
            residual_units(t, residual)
        place = home.place
        return ConstraintSite(
            label=label,
            struct=entity.place.struct.name,
            name=name,
            table=place.table.path,
            prefix=place.prefix,
            span=node.span,
            slots=tuple(t.slots.items),
            residual=tuple(residual),
            guard=guard,
            loss=loss,
            sigma=sigma,
            index_column=index_column,
            require="" if required is None else required.sense,
            require_text=_comparison(node),
            units=() if required is None else required.units,
            doc=node.doc,
        )

    def _typist(self, home: Entity, own: Entity, lets: dict[str, tuple[Binding, Span]]) -> Typist:
        declarations = self.constants.declarations
        slots = Slots([Slot((), home.place.table.path)])
        scope = BodyScope(
            declarations,
            self.paths,
            home,
            own,
            lambda entity, name, span: bind_field(t, entity, name, span),
            self.constants.named,
            lets,
        )
        t = Typist(
            declarations, self.report, HANDLERS, scope, self.constants.named, slots, self.paths
        )
        return t

    def _facts(self, home: Entity) -> frozenset[Fact]:
        """Optionals that are present because this row exists: those around it and its owners."""
        facts: set[Fact] = set()
        here: Entity | None = home
        while here is not None:
            facts.update((here.steps, optional) for optional in here.place.optionals)
            here = self.paths.owner(here)
        return frozenset(facts)

    def _guard(self, t: Typist, home: Entity, node: tree.Expr | None) -> Typed | None:
        """The guard as written, joined with the presence of the enclosing optional structs."""
        guard: Typed | None = None
        span = node.span if node is not None else home.place.struct.node.name.span
        if home.place.optionals:
            around = presence(t, home, home.place.optionals, span)
            guard = around if isinstance(around, Typed) else None
        if node is None:
            return guard
        written = condition(t, node)
        if isinstance(written, Broken):
            return guard
        if guard is None:
            return written
        return Apply(type=BOOL, span=node.span, name="and", args=(guard, written))

    def _lets(self, t: Typist, body: tree.Body, lets: dict[str, tuple[Binding, Span]]) -> None:
        for let in body.lets:
            name = let.name.id
            binding = t.visit(let.value)
            if name in lets:
                t.fail(
                    "E0207",
                    let.name.span,
                    f"`{name}` is declared twice in this body",
                    label="declared again here",
                    labels=[Label(lets[name][1], "first declared here")],
                )
            else:
                lets[name] = (binding, let.name.span)
                if isinstance(binding, Typed):
                    note = Label(let.name.span, f"`{name}` is {binding.type}")
                    t.origins.setdefault(binding, note)


def _comparison(node: tree.Constraint | tree.Fit | tree.Prior) -> str:
    """The comparison of a `require` as written, on one line."""
    if not isinstance(node, tree.Require):
        return ""
    return " ".join(node.body.result.span.text.split())


def fit_names(fits: Sequence[tree.Fit], taken: set[str]) -> list[str]:
    """A name for each `fit`: its collection, numbered if that is ambiguous."""
    names = []
    numbers: dict[str, int] = {}
    for fit in fits:
        base = name = "_".join(p.id for p in fit.collection.parts if p.id != "root")
        while name in taken:
            numbers[base] = numbers.get(base, 1) + 1
            name = f"{base}_{numbers[base]}"
        taken.add(name)
        names.append(name)
    return names


def _index_column(place: Place, node: tree.Constraint) -> str:
    """The field that receives the row of constraint number n: the n-th such field."""
    fields = (f for f in place.struct.fields.values() if f.kind == "constraint_index")
    for field, constraint in zip(fields, place.struct.constraints, strict=False):
        if constraint is node:
            return place.column(field)
    return ""
