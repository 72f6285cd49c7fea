"""Which of two solutions a relation is drawn in: what `Constraint.side` and `mode` keep."""

from __future__ import annotations

import math

from arael.sketch.document.document import Document
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS
from arael.sketch.layout import quantities, tangency
from arael.sketch.layout.operands import (
    Operand,
    cross,
    dot,
    forward,
    operands,
    sign,
    towards,
)
from arael.sketch.layout.plan import Values

#: Centres that are nearer, by the radii, are one.
_ONE_CENTER = 1e-9


def side_of(document: Document, kind: str, args: tuple[str, ...], mode: str = "") -> int:
    """1 or -1 for a constraint or dimension with two solutions, from the geometry; else 0.

    Parameters
    ----------
    kind : of `CONSTRAINTS` or `DIMENSIONS`
    args : canonical handles
    """
    found = operands(document, args)
    values = document.values
    if kind in DIMENSIONS:
        return quantities.side_of_quantity(kind, found, values)
    if kind not in CONSTRAINTS:
        raise KeyError(kind)
    lines = [towards(values, *one.line) for one in found if one.kind == "line"]
    if kind == "parallel" and len(lines) == 2:
        return sign(dot(*lines))
    if kind == "perpendicular" and len(lines) == 2:
        return sign(cross(*lines))
    if kind == "equal_angle":
        return sign(cross(lines[0], lines[1]) * cross(lines[2], lines[3]))
    return _of_tangent(values, found, mode) if kind == "tangent" else 0


def mode_of(document: Document, kind: str, args: tuple[str, ...]) -> str:
    """``outside`` or ``inside`` for circles that are to touch, or to have a distance, as drawn.

    Empty for others, and for a distance of circles that are drawn around one centre.
    """
    found = operands(document, args)
    if kind in ("tangent", "distance") and all(one.is_circular and not one.point for one in found):
        if kind == "distance" and _around_one_center(document.values, *found):
            return ""
        return tangency.circles_mode(document.values, *found)[0]
    return ""


def _around_one_center(values: Values, first: Operand, second: Operand) -> bool:
    apart = math.hypot(*towards(values, first.center, second.center))
    return apart <= _ONE_CENTER * float(values[first.circle.r] + values[second.circle.r])


def _of_tangent(values: Values, found: list[Operand], mode: str) -> int:
    first, second = found
    if first.point:
        return sign(dot(forward(values, first), forward(values, second)))
    if "line" in (first.kind, second.kind):
        line, curve = (first, second) if first.kind == "line" else (second, first)
        return tangency.side_of_line(values, line, curve)
    if first.is_circular and second.is_circular:
        drawn, larger = tangency.circles_mode(values, first, second)
        return larger if (mode or drawn) == "inside" else 0
    return 0
