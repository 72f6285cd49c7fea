"""Where two curves of a constraint touch, or a point lies on a curve."""

from __future__ import annotations

from arael.sketch.document.document import Document
from arael.sketch.document.records import Constraint
from arael.sketch.geometry import Arc, Circle, Curve, Line, Point, curve_of


def contact_of(document: Document, record: Constraint, position: int) -> Point:
    """Point where the operand at a position is touched by the other operand."""
    other = record.args[1 - position]
    if "." in other or document.entities[other].kind == "point":
        at = document.point_at(other)
        x, y = document.values[at : at + 2].tolist()
        return x, y
    curve, second = (
        curve_of(document.entities[name].kind, document.numbers_of(name).tolist())
        for name in (record.args[position], other)
    )
    return touching(curve, second)


def touching(curve: Curve, other: Curve) -> Point:
    """Point of a curve where another one is tangent to it, also on its extension.

    The foot of the centre on a line, the point on the line of centres of two circles; for other
    pairs the nearest of some points.
    """
    if isinstance(curve, Circle | Arc) and isinstance(other, Circle | Arc | Line):
        if isinstance(other, Line):
            return other.point_at(other.nearest(curve.center, carrier=True).t)
        (x1, y1), (x2, y2) = curve.center, other.center
        length = ((x2 - x1) ** 2 + (y2 - y1) ** 2) ** 0.5
        if length > 0.0:
            sign = 1.0 if other.radius <= curve.radius or length >= other.radius else -1.0
            scale = sign * curve.radius / length
            return x1 + scale * (x2 - x1), y1 + scale * (y2 - y1)
    if isinstance(curve, Line) and isinstance(other, Circle | Arc):
        return curve.point_at(curve.nearest(other.center, carrier=True).t)
    points = [other.point_at(k / 256) for k in range(257)]
    return min(points, key=lambda p: curve.nearest(p).distance)
