"""Rule: a component is made of parameters, of numbers that it carries along, and of formulas.

Allowed: parameters of every type; other components; numbers, vectors, matrices and quaternions as
carried data; ``symbolic`` and ``compute`` formulas over all of these; one ``update``, which assigns
to parameters and carried data, its own and those of components within.

Not allowed: texts, optionals, structs, collections and refs; a component without a parameter;
formulas that need each other in a circle; an update of what is not stored, or by a value of another
shape.
"""

from __future__ import annotations

from arael.check.binding import Broken, Entity, describe
from arael.check.constants import Constants
from arael.check.declared import Declarations, FieldDecl
from arael.check.expressions import HANDLERS
from arael.check.guards import Fact
from arael.check.paths import Paths
from arael.check.places import Place, stored_fields
from arael.check.reading import bind_formula, scope_within
from arael.check.report import Reporter
from arael.check.scope import ConstantScope
from arael.check.suggest import did_you_mean
from arael.check.typed import (
    INT,
    REAL,
    Assignment,
    ComponentSite,
    Computed,
    MatrixType,
    Read,
    ScalarType,
    Typed,
    ValueType,
    VectorType,
)
from arael.check.typist import Slots, Typist
from arael.check.walk import postorder
from arael.diagnostics.records import Label
from arael.runtime.layout import Slot
from arael.syntax import tree


def check_members(declarations: Declarations, report: Reporter) -> None:
    """Check what the components of a model are made of."""
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
                label="nothing is solved for",
                help=["declare what a step moves: `param d: vec3`; or make it a `struct`"],
            )


def _check_field(field: FieldDecl, report: Reporter) -> None:
    good = field.component or (
        field.kind == "column"
        and not field.optional
        and field.node.role != "skip"
        and (field.type == REAL or not isinstance(field.type, ScalarType))
    )
    if not good:
        report.error(
            "E0440",
            field.span,
            f"a component cannot hold `{field.text}`",
            label="it moves with every step, so it is made of real numbers",
            help=[
                "carry `real`, vectors, matrices and quaternions; keep the rest in the struct that "
                "has the component"
            ],
        )


class Components:
    """Types the formulas of components, at each place where one is."""

    def __init__(self, paths: Paths, constants: Constants, report: Reporter) -> None:
        self.paths = paths
        self.constants = constants
        self.report = report

    def of(self, place: Place) -> tuple[ComponentSite, ...]:
        """The components that the struct at `place` has, those within others first."""
        found: list[ComponentSite] = []
        for field in place.struct.fields.values():
            if field.component:
                inner = place.values[field.name]
                found += self.of(inner)
                found.append(self._site(inner))
        return tuple(found)

    def _site(self, place: Place) -> ComponentSite:
        """Type everything, so that each mistake is reported although nobody reads it."""
        home = Entity((), place)
        t = self._typist(home)
        computed: list[Computed] = []
        with t.knowing(frozenset[Fact](((), o) for o in place.optionals)):
            for name, node in place.struct.formulas.items():
                value = bind_formula(t, home, name, node.value.span)
                if isinstance(node, tree.Compute) and isinstance(value, Typed):
                    written = t.formulas[home.steps, place.prefix + name]
                    assert isinstance(written, Typed)
                    computed.append(Computed(place.prefix + name, written))
                    self._warn(place, node, written)
            steps = place.struct.update.steps if place.struct.update is not None else ()
            found = (self._assignment(t, home, step) for step in steps)
            updates = tuple(one for one in found if one is not None)
        moved = tuple(p.column(f) for p, f in stored_fields(place) if f.param is not None)
        return ComponentSite(moved, updates, tuple(computed))

    def _warn(self, place: Place, node: tree.Compute, value: Typed) -> None:
        for read in postorder([value]):
            if isinstance(read, Read) and read.version == "trial" and read.parameter:
                name = read.column.removeprefix(place.prefix)
                self.report.warning(
                    "W0602",
                    node.name.span,
                    f"`{node.name.id}` is computed from the parameter `{name}`",
                    label="its derivative will be missing",
                    labels=[Label(read.span, f"`{name}` is read here")],
                    notes=["a `compute` field counts as a constant in every derivative"],
                    help=[f"write `symbolic {node.name.id} = ...`, which is differentiated"],
                )
                return

    def _typist(self, home: Entity) -> Typist:
        declarations = self.constants.declarations
        slots = Slots([Slot((), home.place.table.path)])
        nothing = ConstantScope(declarations, self.constants.named)
        t = Typist(
            declarations, self.report, HANDLERS, nothing, self.constants.named, slots, self.paths
        )
        t.scope = scope_within(t, home)
        return t

    def _assignment(self, t: Typist, home: Entity, step: tree.Setting) -> Assignment | None:
        target = self._target(home.place, step.target)
        value = t.value(step.value)
        if target is None or isinstance(value, Broken):
            return None
        place, field = target
        assert field.type is not None
        if not _fits(field.type, value.type):
            t.fail(
                "E0444",
                step.value.span,
                f"`{step.target}` is {field.type}, and is given {describe(value)}",
                label=f"this is {value.type}",
                labels=[Label(field.span, f"declared `{field.text}` here")],
                help=["give it a value of its own shape; a number fills a vector"],
            )
            return None
        return Assignment(place.column(field), value)

    def _target(self, place: Place, path: tree.Path) -> tuple[Place, FieldDecl] | None:
        *before, last = path.parts
        for part in before:
            inner = place.struct.fields.get(part.id)
            if inner is None or not inner.component:
                return self._not_stored(place, path, part)
            place = place.values[part.id]
        field = place.struct.fields.get(last.id)
        if field is None or field.kind != "column":
            return self._not_stored(place, path, last)
        return place, field

    def _not_stored(self, place: Place, path: tree.Path, part: tree.Ident) -> None:
        struct = place.struct
        if part.id in self.constants.declarations.broken:
            return
        known = [f.name for f in struct.fields.values() if f.kind == "column"]
        formula = struct.formulas.get(part.id)
        self.report.error(
            "E0443",
            part.span,
            f"an update cannot set `{path}`",
            label="this is a formula"
            if formula is not None
            else f"{struct.name} stores no `{part.id}`",
            labels=[Label(formula.name.span, "given here")] if formula is not None else [],
            help=did_you_mean(part.id, known) or [f"it sets what is stored: {', '.join(known)}"],
        )


def _fits(stored: ValueType, given: ValueType) -> bool:
    if stored == given or (stored == REAL and given == INT):
        return True
    return given in (REAL, INT) and isinstance(stored, VectorType | MatrixType)
