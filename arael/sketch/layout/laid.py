"""Records as they are laid out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.records import Constraint, Dimension, Entity, Record
from arael.sketch.expressions.reading import literal
from arael.sketch.layout import following
from arael.sketch.layout.operands import Alike, Operand, sweep_of
from arael.sketch.layout.plan import Plan


@dataclass(slots=True)
class Laid:
    """A record as it is laid out.

    Attributes
    ----------
    record : as it was then
    names : entities that it involves
    plan : what it contributes
    rows, sums, guards : first rows of its instances, in the order of the plan
    inputs : rows of quantities that its sums read
    hidden : first column of each of its hidden unknowns
    constants : offsets of its constants
    shape : `shape_of` the record, of a dimension that has had another value
    """

    record: Record
    names: tuple[str, ...]
    plan: Plan | None = None
    rows: list[int] = field(default_factory=list)
    sums: list[int] = field(default_factory=list)
    guards: list[int] = field(default_factory=list)
    inputs: list[int] = field(default_factory=list)
    hidden: list[int] = field(default_factory=list)
    constants: list[int] = field(default_factory=list)
    shape: tuple[Any, ...] | None = None


def acts(record: Record) -> bool:
    """Whether a record counts: entities do, others where they are active."""
    return isinstance(record, Entity) or (
        isinstance(record, Constraint | Dimension) and record.active
    )


def same_numbers(old: Record | None, new: Record | None) -> bool:
    """Whether two versions of an entity have the same kind and numbers."""
    if not isinstance(old, Entity) or not isinstance(new, Entity):
        return False
    return (old.kind, old.at, old.size) == (new.kind, new.at, new.size)


def shape_of(dimension: Dimension) -> tuple[Any, ...]:
    """What a dimension's rows depend on but for its numbers."""
    value = dimension.value
    return (
        dimension.kind,
        dimension.args,
        dimension.value is None,
        # an expression is a program of its own; its number alone is not what it reads
        dimension.value.text if dimension.value and following.is_live(dimension) else "",
        # slacks start from the geometry when a bound changes
        dimension.low,
        dimension.high,
        dimension.derived,
        dimension.side,
        dimension.mode,
        dimension.active,
        # an expression may follow geometry, or other geometry than before
        None if value is None or literal(value.text) is not None else value.text,
        dimension.broken,
    )


def scalars_of(data: Mapping[str, Any]) -> dict[str, float]:
    """Fields of a struct by the names of their scalars."""
    found: dict[str, float] = {}
    for name, value in data.items():
        if isinstance(value, int | float):
            found[name] = float(value)
        else:
            found.update({f"{name}[{k}]": float(one) for k, one in enumerate(value)})
    return found


def own_rows(entity: Entity, values: NDArray[np.float64], alike: Alike) -> Plan:
    """Equations of an arc: its ends are on it. Radii of round curves stay positive."""
    plan = Plan()
    curve = Operand(entity, "", entity.at)
    for radius in curve.ellipse[1:3] if curve.is_elliptic else curve.circle[1:]:
        if values[radius] > 0:
            plan.guard("ScalarValue", radius)
        else:
            plan.unguarded = True
    if not curve.ends:
        return plan
    start, end = curve.ends
    if entity.kind == "arc":
        circle = curve.circle
        plan.add("PointOnCircle", start, *circle)
        plan.add("PointOnCircle", end, *circle)
    else:
        plan.add("PointOnEllipse", start, *curve.ellipse)
        plan.add("PointOnEllipse", end, *curve.ellipse)
    # Where start and end are one place, the sign of the sweep is that of rounding.
    if alike.same(start, end):
        return plan
    side = 1.0 if sweep_of(values, curve) < np.pi else -1.0
    plan.guard("SweepGuard", curve.center, start, end, side=side)
    return plan
