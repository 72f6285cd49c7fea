"""Entities of a document as curves of `arael.sketch.geometry`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from arael.sketch.document.document import Document
from arael.sketch.document.records import Entity

if TYPE_CHECKING:
    from arael.sketch.geometry.curve import Curve


def curve_of(document: Document, entity: Entity) -> Curve:
    """The curve of an entity that is not a point.

    Arcs run as they were drawn. KeyError for a point.
    """
    # imported here: start-up time
    from arael.sketch.geometry.circular import Arc, Circle
    from arael.sketch.geometry.elliptic import Ellipse, EllipticArc
    from arael.sketch.geometry.line import Line
    from arael.sketch.geometry.splines import Bezier, BSpline

    v = document.numbers_of(entity.name).tolist()
    pairs: list[tuple[float, float]] = list(zip(v[0::2], v[1::2], strict=False))
    if entity.kind == "line":
        return Line(pairs[0], pairs[1])
    if entity.kind == "circle":
        return Circle(pairs[0], v[2])
    if entity.kind == "arc":
        arc = Arc.between(pairs[0], pairs[1], pairs[2], v[6])
        return arc.reversed() if entity.clockwise else arc
    if entity.kind == "ellipse":
        return Ellipse(pairs[0], v[2], v[3], v[4])
    if entity.kind == "earc":
        elliptic = EllipticArc.between(pairs[0], pairs[1], pairs[2], v[6], v[7], v[8])
        return elliptic.reversed() if entity.clockwise else elliptic
    if entity.kind == "bezier":
        return Bezier((pairs[0], pairs[1], pairs[2], pairs[3]))
    if entity.kind == "bspline":
        return BSpline(tuple(pairs))
    raise KeyError(entity.kind)
