"""Rule: an update assigns to stored values of its component, in order.

Allowed: ``base = base * exp(d)``, ``d = 0`` (a number fills a vector or a matrix),
``inner.d = 0`` of a nested component; each reads the results of the assignments before it.

Not allowed: to set a formula, a whole component, a part of a vector, or an unknown member; a value
of another shape or unit.
"""

from __future__ import annotations

from arael.check.binding import Broken, Entity
from arael.check.declared import FieldDecl
from arael.check.places import Place
from arael.check.suggest import did_you_mean
from arael.check.typed import (
    INT,
    REAL,
    Assignment,
    MatrixType,
    Typed,
    ValueType,
    VectorType,
)
from arael.check.types import size_of
from arael.check.typist import Typist
from arael.check.units_messages import sources, written
from arael.check.units_quantities import Clash, joined, spread
from arael.diagnostics.records import Label
from arael.syntax import tree


class Updates:
    """Types the update of the component `home`."""

    def __init__(self, t: Typist, home: Entity) -> None:
        self.t = t
        self.home = home

    def all(self) -> tuple[Assignment, ...]:
        """Each assignment, in order."""
        update = self.home.place.struct.update
        steps = update.steps if update is not None else ()
        assignments = (self._assignment(step) for step in steps)
        return tuple(assignment for assignment in assignments if assignment is not None)

    def _assignment(self, step: tree.Setting) -> Assignment | None:
        target = self._target(self.home.place, step.target)
        value = self.t.value(step.value)
        if target is None or isinstance(value, Broken):
            return None
        place, field = target
        assert field.type is not None
        if not _fits(field.type, value.type):
            self.t.fail(
                "E0444",
                step.value.span,
                f"`{step.target}` is {field.type}, and is set to {value.type}",
                label=f"this is {value.type}",
                labels=[Label(field.span, f"declared `{field.text}` here")],
                help=[f"assign a {field.type}"]
                if size_of(field.type) == 1
                else [f"assign a {field.type}, or a number for all its elements"],
            )
            return None
        self._check_unit(step, field, value)
        return Assignment(place.column(field), value)

    def _check_unit(self, step: tree.Setting, field: FieldDecl, value: Typed) -> None:
        t, size = self.t, size_of(value.type)
        if not field.unit and not written(t, value):
            return
        try:
            for a, b in zip(
                spread(field.quantity, size), spread(t.units.of(value), size), strict=True
            ):
                joined(a, b)
        except Clash as clash:
            t.fail(
                "E0321",
                step.value.span,
                f"`{step.target}` is in {clash.first}, and is set to a value in {clash.second}",
                label=f"this is in {clash.second}",
                labels=[Label(field.span, f"declared `{field.text}` here"), *sources(t, value)],
                help=["correct the formula, or the declared unit"],
            )

    def _target(self, place: Place, path: tree.Path) -> tuple[Place, FieldDecl] | None:
        for number, part in enumerate(path.parts):
            field = place.struct.fields.get(part.id)
            rest = path.parts[number + 1 :]
            if field is not None and field.component and rest:
                place = place.values[part.id]
            elif field is not None and field.kind == "column" and not rest:
                return place, field
            else:
                self._invalid_target(place, path, part, field)
                break
        return None

    def _invalid_target(
        self, place: Place, path: tree.Path, part: tree.Ident, field: FieldDecl | None
    ) -> None:
        struct = place.struct
        if part.id in self.t.declarations.broken:
            return
        stored = [f.name for f in struct.fields.values() if f.kind == "column"]
        formula = struct.formulas.get(part.id)
        labels = []
        help_ = [f"{struct.name} stores {', '.join(stored)}"]
        if field is not None and field.component:
            label = f"this is the component {field.struct}"
            inner = place.values[part.id].struct.fields.values()
            help_ = [f"set its members: `{path}.{next(iter(inner)).name} = ...`"]
        elif field is not None:
            label = "it is set as a whole"
            help_ = [f"write `{part.id} = [...]`"]
        elif formula is not None:
            label = "this is a formula"
            labels = [Label(formula.name.span, "given here")]
        else:
            label = f"{struct.name} stores no `{part.id}`"
            help_ = did_you_mean(part.id, stored) or help_
        self.t.report.error(
            "E0443",
            part.span,
            f"an update cannot set `{path}`",
            label=label,
            labels=labels,
            help=help_,
        )


def _fits(stored: ValueType, value_type: ValueType) -> bool:
    if stored == value_type or (stored == REAL and value_type == INT):
        return True
    return value_type in (REAL, INT) and isinstance(stored, VectorType | MatrixType)
