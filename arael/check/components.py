"""Rule: a component consists of parameters, of stored numbers, and of formulas.

Allowed: parameters of every type; other components; numbers, vectors, matrices and quaternions as
stored data; ``symbolic`` and ``compute`` formulas over all of these.

Not allowed: texts, whole numbers, optionals, structs, collections and refs; a component without a
parameter; formulas with circular dependencies; native functions and ``.value`` in formulas that are
evaluated with each step.
"""

from __future__ import annotations

from arael.check.binding import Entity
from arael.check.constants import Constants
from arael.check.declared import Declarations, FieldDecl
from arael.check.expressions import HANDLERS
from arael.check.field_reads import bind_formula, definition, scope_within
from arael.check.guards import Fact
from arael.check.paths import Paths
from arael.check.places import Place, stored_fields
from arael.check.report import Reporter
from arael.check.scope import ConstantScope
from arael.check.typed import REAL, ComponentSite, Definition, Invoke, Read, ScalarType, Typed
from arael.check.typist import Slots, Typist
from arael.check.updates import Updates
from arael.check.walk import postorder
from arael.runtime.layout import Slot
from arael.syntax import tree


def check_members(declarations: Declarations, report: Reporter) -> None:
    """Check the members of the components of a model."""
    for struct in declarations.structs.values():
        if not struct.component:
            continue
        for field in struct.fields.values():
            _check_field(field, report)
        named = {m.name.id for m in struct.node.members if isinstance(m, tree.Field)}
        if not struct.has_params and not named & declarations.broken:
            report.error(
                "E0441",
                struct.node.name.span,
                f"component `{struct.name}` has no parameter",
                label="no parameter here",
                help=["declare the step variables: `param d: vec3`; or make it a `struct`"],
            )


def _check_field(field: FieldDecl, report: Reporter) -> None:
    if field.component or (
        field.kind == "column"
        and not field.optional
        and field.node.role != "skip"
        and (field.type == REAL or not isinstance(field.type, ScalarType))
    ):
        return
    what = f"{'skip ' if field.node.role == 'skip' else ''}{field.text}"
    report.error(
        "E0440",
        field.span,
        f"a component cannot hold `{what}`",
        label="neither a parameter nor stored numbers",
        help=[
            "a component has parameters, and real numbers, vectors, matrices and quaternions",
            f"declare `{field.name}` in the struct that has the component",
        ],
    )


class Components:
    """Types the formulas of components, at each of their places."""

    def __init__(self, paths: Paths, constants: Constants, report: Reporter) -> None:
        self.paths = paths
        self.constants = constants
        self.report = report

    def of(self, place: Place) -> tuple[ComponentSite, ...]:
        """The components of the struct at `place`, nested ones first."""
        sites: list[ComponentSite] = []
        for field in place.struct.fields.values():
            if field.component:
                inner = place.values[field.name]
                sites += self.of(inner)
                sites.append(self._site(inner))
        if place.struct.formulas and not place.struct.component:
            sites.append(self._ties(place))
        return tuple(sites)

    def _ties(self, place: Place) -> ComponentSite:
        """The parameters of a struct that are derived from others, as a component that never moves.

        Allowed: ``param b = 2 * a + 1`` over parameters of the struct, constants and functions.
        Not allowed: data, parameters of other structs, a formula without a parameter.
        """
        home = Entity((), place)
        t = self._typist(home)
        definitions: list[Definition] = []
        with t.knowing(frozenset[Fact](((), o) for o in place.optionals)):
            for name, node in place.struct.formulas.items():
                bind_formula(t, home, name, node.value.span)
                value = definition(t, home, name, node.value.span)
                if isinstance(value, Typed) and _is_tie(t, node, value):
                    check_refreshed(t, value)
                    definitions.append(Definition(place.prefix + name, value))
        span = place.struct.node.name.span
        return ComponentSite(place.struct.name, span, (), (), tuple(definitions), ())

    def _site(self, place: Place) -> ComponentSite:
        """Type everything, so that mistakes in unused formulas are reported too."""
        home = Entity((), place)
        t = self._typist(home)
        symbolic: list[Definition] = []
        computed: list[Definition] = []
        with t.knowing(frozenset[Fact](((), o) for o in place.optionals)):
            for name, node in place.struct.formulas.items():
                bind_formula(t, home, name, node.value.span)
                value = definition(t, home, name, node.value.span)
                if isinstance(value, Typed):
                    kept = isinstance(node, tree.Compute)
                    if kept:
                        check_refreshed(t, value)
                    (computed if kept else symbolic).append(Definition(place.prefix + name, value))
            updates = Updates(t, home).all()
        for assignment in updates:
            check_refreshed(t, assignment.value)
        moved = tuple(p.column(f) for p, f in stored_fields(place) if f.param is not None)
        return ComponentSite(
            struct=place.struct.name,
            span=place.struct.node.name.span,
            moved=moved,
            updates=updates,
            symbolic=tuple(symbolic),
            computed=tuple(computed),
        )

    def _typist(self, home: Entity) -> Typist:
        declarations = self.constants.declarations
        slots = Slots([Slot((), home.place.table.path)])
        nothing = ConstantScope(declarations, self.constants.named)
        t = Typist(
            declarations, self.report, HANDLERS, nothing, self.constants.named, slots, self.paths
        )
        t.scope = scope_within(t, home)
        return t


def _is_tie(t: Typist, node: tree.Symbolic | tree.Compute | tree.Tie, value: Typed) -> bool:
    """Whether a derived parameter reads parameters alone; reports an error if not."""
    reads = [n for n in postorder([value]) if isinstance(n, Read)]
    data = next((n for n in reads if n.version != "trial"), None)
    if reads and data is None:
        return True
    name = node.name.id
    if data is None:
        t.fail(
            "E0663",
            node.value.span,
            f"`{name}` is derived from no parameter",
            label="this is a constant",
            help=[f"declare its type for a parameter: `param {name}: real = ...`, or use `const`"],
        )
    else:
        t.fail(
            "E0663",
            data.span,
            f"`{name}` is derived from more than parameters",
            label="not a parameter of this struct",
            labels=t.origin(data),
            help=["use parameters of the struct and constants; or write the formula with `let`"],
        )
    return False


def check_refreshed(t: Typist, value: Typed) -> None:
    """Report operations that cannot be evaluated with each step, from the state of one row."""
    for node in postorder([value]):
        if isinstance(node, Read) and node.version == "stored":
            t.fail(
                "E0308",
                node.span,
                "`.value` cannot be used here",
                label="the value at the start of the solve",
                notes=["`compute` and `update` read the current values of their own component"],
                help=["store a copy as data of the component"],
            )
        elif isinstance(node, Invoke) and node.value is None:
            t.fail(
                "E0445",
                node.span,
                f"the native function `{node.function}` is called outside a residual",
                label="evaluated with each step, where native code cannot be called",
                help=["call it in a `symbolic` formula, or give it a formula: `fn f(x) = ...`"],
            )
